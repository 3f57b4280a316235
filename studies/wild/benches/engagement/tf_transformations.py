import numpy
from transforms3d.quaternions import quat2mat


def translation_matrix(translation):
    matrix = numpy.identity(4)
    matrix[:3, 3] = translation
    return matrix


def quaternion_matrix(quaternion):
    matrix = numpy.identity(4)
    matrix[:3, :3] = quat2mat([quaternion[3], *quaternion[:3]])
    return matrix


concatenate_matrices, inverse_matrix = numpy.dot, numpy.linalg.inv
translation_from_matrix = lambda matrix: matrix[:3, 3]
