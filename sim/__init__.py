"""The simulated world of the table assembly: torso, leg, table, person, sensors. PyBullet or MuJoCo under virtual time."""
