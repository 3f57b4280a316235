import serial


class Motors:
    def __init__(self, port="/dev/ttyUSB0"):
        self.line = serial.Serial(port, 115200)

    def pwm(self, share):
        self.line.write(b"L%d\n" % round(share * 255))

    def move(self, pose, speed):
        self.line.write(b"M%.2f %.2f %.2f\n" % (*pose, speed))
