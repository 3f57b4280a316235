from transforms3d.euler import quat2euler

euler_from_quaternion = lambda quaternion: quat2euler([quaternion[3], *quaternion[:3]])
