"""How far the table's two physics engines agree."""
