"""How often what people say is understood (`w2c evaluate language`)."""
