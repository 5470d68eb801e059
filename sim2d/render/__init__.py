"""What a world looks like: surfaces and their textures, light, rays and pixels."""
