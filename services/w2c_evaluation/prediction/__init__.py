"""How often an instruction leads to an accepted point (`w2c evaluate prediction`)."""
