"""`w2c replay`: a recording on the bus once more, in a namespace of its own."""
