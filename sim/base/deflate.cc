#include "sim/base/deflate.h"

#include <zlib.h>

#include "sim/base/require.h"

namespace caltwin {

std::string Deflated(std::string_view text) {
  uLongf size = compressBound(static_cast<uLong>(text.size()));
  std::string packed(size, '\0');
  const int result = compress2(reinterpret_cast<Bytef*>(packed.data()),
                               &size,
                               reinterpret_cast<const Bytef*>(text.data()),
                               static_cast<uLong>(text.size()),
                               Z_BEST_COMPRESSION);
  Require(result == Z_OK, "a text can be compressed");
  packed.resize(size);
  return packed;
}

}  // namespace caltwin
