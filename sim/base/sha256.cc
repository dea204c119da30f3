#include "sim/base/sha256.h"

#include <array>

#include <fmt/format.h>
#include <openssl/evp.h>

#include "sim/base/require.h"

namespace caltwin {

std::string Sha256(std::string_view bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  const int done = EVP_Digest(
      bytes.data(), bytes.size(), digest.data(), &length, EVP_sha256(), nullptr);
  Require(done == 1, "OpenSSL has SHA-256");
  std::string hex;
  for (unsigned int i = 0; i < length; ++i) hex += fmt::format("{:02x}", digest[i]);
  return hex;
}

}  // namespace caltwin
