"""Files of one export know each other: those of two do not compile together."""

from __future__ import annotations

import hashlib

from codegen.export import Export
from codegen.template import AtTemplate

NUMBER = """
/* Which export this is: its other files ask. */
#define @{PREFIX}_EXPORT @number
"""
CHECK = """#include "@prefix.h"
#if @{PREFIX}_EXPORT != @number
#error "@prefix.h is of another export than this file: export again"
#endif
"""
"""A run that is killed while it puts its files in place leaves some of the export before."""


def of_one_export(export: Export) -> tuple[str, str, str]:
    """Return header, source and generated functions with a number that all three have."""
    texts = export.header, export.source, export.generated
    digest = hashlib.sha256("\0".join(texts).encode()).hexdigest()[:8]
    names = {"prefix": export.prefix, "PREFIX": export.prefix.upper(), "number": f"0x{digest}"}
    number, check = (AtTemplate(text).substitute(names) for text in (NUMBER, CHECK))
    guard, include = f"#define {names['PREFIX']}_H\n", f'#include "{export.prefix}.h"\n'
    header, source, generated = texts
    return (
        header.replace(guard, guard + number, 1),
        source.replace(include, check, 1),
        check + generated,
    )
