"""`w2c bench recording`: what recording costs and loses, and how late a replay is."""
