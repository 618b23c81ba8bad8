"""What speaks against a target: the veto list, and advice that leaves the operator the choice."""
