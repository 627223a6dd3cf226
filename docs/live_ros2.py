"""A ROS 2 robot as a live target of morph: joint states and commands as JSON lines.

Runs with ROS 2 and its Python alone, without morph: `python3 live_ros2.py` once ROS 2 is
sourced and the robot's controllers run. docs/live.md says what the lines mean.
"""

import contextlib
import json
import sys
import threading
import time

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

PERIOD = 0.05  # s; the task's control period
JOINTS = {"slide": ("m", "N"), "hinge": ("rad", "N m")}  # as in the body's description
DRIVEN = ["slide"]  # in the order of the controller's parameter `joints`
COMMANDS = "/effort_controller/commands"  # a forward_command_controller of interface effort
PATIENCE = 0.25  # s without a command after which the robot is held safe


def say(message: dict) -> None:
    """Write one line to morph; ROS logs to standard error, so nothing else comes in between."""
    sys.stdout.write(json.dumps(message) + "\n")
    sys.stdout.flush()


class Bridge(Node):
    """Says a state each period while a trial runs, and holds the robot safe when none does."""

    def __init__(self) -> None:
        super().__init__("morph_bridge")
        self.publisher = self.create_publisher(Float64MultiArray, COMMANDS, 10)
        self.create_subscription(JointState, "/joint_states", self.saw, qos_profile_sensor_data)
        self.create_timer(PERIOD, self.tick)
        self.state, self.stamp, self.sent = {}, 0.0, 0.0
        self.running, self.told = False, 0.0

    def saw(self, message: JointState) -> None:
        """Keep the newest state by name: nobody promises the order of joints."""
        at = {name: index for index, name in enumerate(message.name)}
        # A driver that measures no velocity sends none; it is no target then.
        if JOINTS.keys() <= at.keys() and len(message.velocity) == len(message.name):
            self.state = {
                f"{name}.{what}": values[at[name]]
                for name in JOINTS
                for what, values in (("position", message.position), ("velocity", message.velocity))
            }
            self.stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec

    def tick(self) -> None:
        """Say the newest state, if there is a new one."""
        if not self.running:
            return
        if self.stamp == self.sent:
            self.hold()
            say({"error": "no new joint states in a control period"})
        elif time.monotonic() - self.told > PATIENCE:
            self.hold()
        else:
            self.sent = self.stamp
            say({"t": self.stamp, "state": self.state})

    def obey(self, message: dict) -> None:
        """Do what morph says."""
        if "begin" in message:
            # Here a robot would go, or be put by hand, to where the task begins.
            self.running, self.sent, self.told = True, 0.0, time.monotonic()
        elif "command" in message and self.running:
            self.told = time.monotonic()
            self.publish([float(message["command"][name]) for name in DRIVEN])
        elif "stop" in message:
            self.hold()
            say({"stopped": True})

    def hold(self) -> None:
        """No effort: safe for a cart. An arm needs its brakes, or a controller that holds it."""
        self.running = False
        self.publish([0.0] * len(DRIVEN))

    def publish(self, efforts: list) -> None:
        """Send efforts to the controller."""
        message = Float64MultiArray()
        message.data = efforts
        self.publisher.publish(message)


def listen(bridge: Bridge) -> None:
    """Obey line after line; when morph is gone, hold safe and end."""
    try:
        for line in sys.stdin:
            bridge.obey(json.loads(line))
    finally:
        bridge.hold()
        rclpy.shutdown()


def main() -> None:
    """Speak with morph until it is gone."""
    rclpy.init()
    bridge = Bridge()
    channels = [
        {"name": f"{name}.{what}", "unit": unit + per}
        for name, (unit, _) in JOINTS.items()
        for what, per in (("position", ""), ("velocity", "/s"))
    ]
    actuators = [{"name": name, "unit": JOINTS[name][1]} for name in DRIVEN]
    said = {"channels": channels, "actuators": actuators, "period_s": PERIOD, "clock": "target"}
    say({"schema": "morph.live/1", **said})
    threading.Thread(target=listen, args=(bridge,), daemon=True).start()
    with contextlib.suppress(ExternalShutdownException):
        rclpy.spin(bridge)


if __name__ == "__main__":
    main()
