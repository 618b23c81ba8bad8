"""What finding phrases in pictures costs, model by model."""
