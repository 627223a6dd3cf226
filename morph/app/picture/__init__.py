"""Pictures of a motion: the scene around the robot, the camera, the canvas, the file."""
