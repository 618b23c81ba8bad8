"""A recording as a file of Rerun: what Foxglove is shown, in Rerun's own columns."""
