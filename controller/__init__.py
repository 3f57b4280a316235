"""The code under test: a robot that hands over table legs to a person. It is handed its ports."""
