"""The laws of autopilots' firmware, one file each, written as a user would write them."""
