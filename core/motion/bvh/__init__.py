"""BVH files: read in any dialect, understood by their motion, made into clips."""
