"""Clips of motion and the motion graph that is cut from them."""
