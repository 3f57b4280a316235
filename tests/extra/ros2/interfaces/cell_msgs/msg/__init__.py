from array import array

from cell_msgs import generated

Point = generated("cell_msgs.msg._point", "Point", x=0.0, y=0.0)
Scan = generated(
    "cell_msgs.msg._scan", "Scan", frame="", near=False, count=0, origin=Point(), ranges=array("d"), labels=[]
)
Other = generated("cell_msgs.msg._other", "Other", frame="")
