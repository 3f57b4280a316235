"""The simulated world of the table assembly in virtual time: torso, leg, table, person, sensors."""
