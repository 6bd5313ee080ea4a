"""How do I use it from a terminal?"""
