"""How do I use it from a terminal?"""

import pen_mhe as pen_mhe  # first of all rooms: it says which of them something else shadows
