"""The code under test: a robot that hands over table legs to a person. Its ports are passed in."""
