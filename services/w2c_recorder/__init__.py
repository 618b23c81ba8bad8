"""The recorder: everything on the bus, byte for byte, into MCAP; and what reads it back."""
