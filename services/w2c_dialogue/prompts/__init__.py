"""What models are asked, and how their answers are read. Prompt sets are data, chosen per model."""
