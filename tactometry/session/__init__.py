"""What passes between protocol and rig: requests, answers, events, the loop, and replay."""
