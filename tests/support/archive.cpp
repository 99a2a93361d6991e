#include "tests/support/archive.h"

#include <zip.h>

#include <cstdlib>

namespace mvw {

Bytes zip_of(const std::vector<std::pair<std::string, std::string>>& files) {
    zip_error_t error;
    zip_error_init(&error);
    zip_source_t* target = zip_source_buffer_create(nullptr, 0, 0, &error);
    zip_source_keep(target);
    zip_t* archive = zip_open_from_source(target, ZIP_CREATE | ZIP_TRUNCATE, &error);
    for (const auto& [name, text] : files) {
        const zip_int64_t at =
            zip_file_add(archive, name.c_str(), zip_source_buffer(archive, text.data(), text.size(), 0), 0);
        zip_file_set_mtime(archive, static_cast<zip_uint64_t>(at), 1'000'000'000, 0);
    }
    if (zip_close(archive) != 0 || zip_source_open(target) != 0) std::abort();
    zip_source_seek(target, 0, SEEK_END);
    Bytes bytes(static_cast<std::size_t>(zip_source_tell(target)));
    zip_source_seek(target, 0, SEEK_SET);
    zip_source_read(target, bytes.data(), bytes.size());
    zip_source_close(target);
    zip_source_free(target);
    return bytes;
}

Bytes threemf_of(const std::string& model) {
    return zip_of({{"_rels/.rels", R"(<?xml version="1.0"?><Relationships><Relationship Id="r" Target="/3D/m.model" )"
                                   R"(Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>)"
                                   "</Relationships>"},
                   {"3D/m.model", model}});
}

}  // namespace mvw
