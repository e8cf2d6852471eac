"""Makes the OpenRTM of `make test-openrtm` importable as an installed one, in every process.

Its folder and what its .pth file adds come behind the standard library, where the `uuid` that
OpenRTM has beside its own modules does no harm; on PYTHONPATH they would come before it.
"""

from __future__ import annotations

import os
import site

site.addsitedir(os.environ["OPENRTM_SITE"])
