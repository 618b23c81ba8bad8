"""The modules of the dialogue on lines of JSON, without a robot: for evaluation."""
