"""How is a recording estimated that is longer than memory? In parts, as the whole would be."""
