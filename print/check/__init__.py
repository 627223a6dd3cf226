"""What is looked at in a part before any slicer is asked, one file a check."""
