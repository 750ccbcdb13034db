"""Which links a walker takes more often than others."""

WEIGHTING_ITEMS = [
    ("LINKS", "Links", "Every link is equally likely, also those that only shuffle"),
    ("GOODNESS", "Goodness", "Smooth transitions are more likely than rough ones"),
    ("VARIABILITY", "Variability", "Places with many ways in and out are more likely"),
    ("PLACES", "Places Evenly", "Places where the walker has seldom been are more likely"),
    ("CLIPS", "Clip Weights", "Each clip is as likely as its weight says"),
]
