"""The homing bench: contestants, home vector fields, walks home, table and figures."""
