namespace lake {}
