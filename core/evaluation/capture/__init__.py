"""The capture director: which motion that is missing would open most of the ground?"""
