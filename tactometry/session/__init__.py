"""Interface of protocol and rig: requests, answers, events, loop, replay."""
