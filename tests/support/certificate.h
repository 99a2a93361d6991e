// A certificate for tests of TLS: made anew, for 127.0.0.1 and localhost, signed by itself.
#pragma once
#include <string>

namespace mvw::test {

/// Writes the certificate and its key as PEM files.
void make_certificate(const std::string& cert_path, const std::string& key_path);

}  // namespace mvw::test
