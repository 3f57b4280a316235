from cell_msgs import generated


class Grasp:
    Request = generated("cell_msgs.srv._grasp", "Grasp_Request", force=0.0)
    Response = generated("cell_msgs.srv._grasp", "Grasp_Response", held=False)


Grasp.__module__ = "cell_msgs.srv._grasp"
