"""Walks of the scene's character: what is asked for, the motion that becomes of it, and what is left in the scene."""
