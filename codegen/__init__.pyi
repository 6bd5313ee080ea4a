from codegen.export import Export as Export
from codegen.exportable import EXPORTABLE as EXPORTABLE
from codegen.exported import Exported as Exported
from codegen.folder import export_c as export_c
from codegen.sizes import Sizes as Sizes
from codegen.sizes import find_target as find_target
from codegen.sizes import measure as measure
