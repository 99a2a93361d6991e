#include "codec/mesh/io/gltf_unpack.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <set>
#include <vector>

#include "codec/mesh/io/errors.h"
#include "codec/mesh/io/gltf_accessor.h"
#include "codec/mesh/io/gltf_draco.h"
#include "codec/mesh/io/gltf_meshopt.h"
#include "codec/mesh/io/gltf_node.h"

namespace mvw {
namespace {

/// All of a file may unpack to kMostPerByte times its bytes (meshopt's views come to a quarter of it, Draco's streams
/// of real meshes to less) and this much more.
constexpr std::uint64_t kMostPerByte = 4 * kMostMeshoptPerByte, kFreeBytes = 1u << 24;

template <typename Extensible>
const tinygltf::Value* extension_of(const Extensible& object, const char* name) {
    const auto found = object.extensions.find(name);
    return found == object.extensions.end() ? nullptr : &found->second;
}

class Unpacker {
 public:
    explicit Unpacker(tinygltf::Model& model) : model_(model), budget_(kFreeBytes) {
        for (const tinygltf::Buffer& buffer : model.buffers) budget_ += kMostPerByte * buffer.data.size();
    }

    Result<void> run() {
        for (tinygltf::Mesh& mesh : model_.meshes)
            for (tinygltf::Primitive& primitive : mesh.primitives)
                if (const auto done = take_draco(primitive); !done) return done;
        for (const int index : used_accessors()) {
            for (const int view : views_of(accessor(index)))
                if (const auto done = in_range(view, model_.bufferViews) ? take_meshopt(view) : Result<void>(); !done)
                    return Error{done.error().code, 0, fmt::format("buffer view {} {}", view, done.error().message)};
            if (!accessor(index).sparse.isSparse) continue;
            if (const auto done = take_sparse(index); !done) return done;
        }
        return {};
    }

 private:
    tinygltf::Accessor& accessor(int index) { return model_.accessors[static_cast<std::size_t>(index)]; }

    std::set<int> used_accessors() const {
        std::set<int> used;
        for (const tinygltf::Mesh& mesh : model_.meshes) {
            for (const tinygltf::Primitive& primitive : mesh.primitives) {
                used.insert(primitive.indices);
                for (const auto& [name, index] : primitive.attributes) used.insert(index);
            }
        }
        for (const tinygltf::Node& node : model_.nodes)
            if (const tinygltf::Value* extension = extension_of(node, kInstancing))
                for (const std::string& name : member_of(*extension, "attributes").Keys())
                    used.insert(index_of(member_of(*extension, "attributes"), name));
        std::erase_if(used, [&](int index) { return !in_range(index, model_.accessors); });
        return used;
    }

    static std::vector<int> views_of(const tinygltf::Accessor& accessor) {
        if (!accessor.sparse.isSparse) return {accessor.bufferView};
        return {accessor.bufferView, accessor.sparse.indices.bufferView, accessor.sparse.values.bufferView};
    }

    Result<void> spend(std::uint64_t rows, std::uint64_t row) {
        if (rows > budget_ / row) return Error{Errc::LimitExceeded, 0, "would unpack to more than its bytes can hold"};
        budget_ -= rows * row;
        return {};
    }

    int add_buffer(std::vector<unsigned char> bytes) {
        model_.buffers.emplace_back();
        model_.buffers.back().data = std::move(bytes);
        return static_cast<int>(model_.buffers.size()) - 1;
    }

    int add_view(std::vector<unsigned char> bytes) {
        tinygltf::BufferView view;
        view.byteLength = bytes.size();
        view.buffer = add_buffer(std::move(bytes));
        model_.bufferViews.push_back(std::move(view));
        return static_cast<int>(model_.bufferViews.size()) - 1;
    }

    int add_accessor(PlainRows rows) {
        tinygltf::Accessor added;
        added.bufferView = add_view(std::move(rows.bytes));
        added.componentType = rows.component_type;
        added.type = rows.type;
        added.count = rows.count;
        model_.accessors.push_back(std::move(added));
        return static_cast<int>(model_.accessors.size()) - 1;
    }

    /// Accessors of what a Draco stream holds: of its corners, and of its attributes by their unique id.
    struct DracoAccessors {
        int corners = -1;
        std::map<int, int> attributes;
    };

    Result<void> take_draco(tinygltf::Primitive& primitive) {
        const tinygltf::Value* extension = extension_of(primitive, kDracoExtension);
        if (extension == nullptr) return {};
        const int view = index_of(*extension, "bufferView");
        const auto [known, is_new] = draco_.try_emplace(view);  // each once, however many primitives share it
        if (is_new)
            if (const auto done = open_draco(view, known->second); !done) return done;
        primitive.indices = known->second.corners;
        primitive.mode = TINYGLTF_MODE_TRIANGLES;
        const tinygltf::Value& attributes = member_of(*extension, "attributes");
        for (auto& [name, index] : primitive.attributes) {
            if (!attributes.Has(name)) continue;
            const auto found = known->second.attributes.find(index_of(attributes, name));
            if (found == known->second.attributes.end())
                return malformed(fmt::format("buffer view {} has no {} in its Draco stream", view, name));
            const bool normalized = in_range(index, model_.accessors) && accessor(index).normalized;
            index = found->second;
            accessor(index).normalized = normalized;
        }
        return {};
    }

    Result<void> open_draco(int view, DracoAccessors& to) {
        const Result<ByteSpan> stream = open_view(model_, view);
        if (!stream) return stream.error();
        Result<DracoRows> rows = decode_gltf_draco(*stream);
        if (!rows) return Error{rows.error().code, 0, fmt::format("buffer view {} {}", view, rows.error().message)};
        std::uint64_t bytes = rows->corners.bytes.size();
        for (const auto& [id, attribute] : rows->attributes) bytes += attribute.bytes.size();
        if (const auto fine = spend(bytes, 1); !fine)
            return Error{fine.error().code, 0, fmt::format("buffer view {} {}", view, fine.error().message)};
        to.corners = add_accessor(std::move(rows->corners));
        for (auto& [id, attribute] : rows->attributes) to.attributes[id] = add_accessor(std::move(attribute));
        return {};
    }

    Result<void> take_meshopt(int index) {
        tinygltf::BufferView& view = model_.bufferViews[static_cast<std::size_t>(index)];
        const tinygltf::Value* extension = extension_of(view, kMeshoptExtension);
        if (extension == nullptr) return {};
        const Result<PackedView> packed = packed_view_of(model_, *extension);
        if (!packed) return packed.error();
        if (const auto fine = spend(packed->count, packed->stride); !fine) return fine;
        Result<std::vector<unsigned char>> bytes = unpack_view(*packed);
        if (!bytes) return bytes.error();
        view.byteOffset = 0;
        view.byteLength = bytes->size();
        view.byteStride = packed->indices() ? 0 : packed->stride;
        view.buffer = add_buffer(std::move(bytes).value());
        view.extensions.erase(kMeshoptExtension);  // so that it is unpacked once
        return {};
    }

    Result<void> take_sparse(int index) {
        const std::string name = fmt::format("accessor {}", index);
        const tinygltf::Accessor sparse = accessor(index);
        const auto part = [&](int view, int offset, int component_type, int type) {
            tinygltf::Accessor of = sparse;
            of.bufferView = view;
            of.byteOffset = static_cast<std::size_t>(std::max(0, offset));
            of.componentType = component_type;
            of.type = type;
            of.normalized = false;  // raw numbers
            of.count = static_cast<std::size_t>(std::max(0, sparse.sparse.count));
            return open_accessor(model_, of, name);
        };
        const auto& [count, is_sparse, places, changes] = sparse.sparse;
        const Result<Values> at =
            part(places.bufferView, places.byteOffset, places.componentType, TINYGLTF_TYPE_SCALAR);
        if (!at) return at.error();
        const Result<Values> to = part(changes.bufferView, changes.byteOffset, sparse.componentType, sparse.type);
        if (!to) return to.error();
        if (const auto fine = spend(sparse.count, to->row); !fine)
            return Error{fine.error().code, 0, name + " " + fine.error().message};

        std::vector<unsigned char> bytes(sparse.count * to->row);  // zeros, where nothing else is said
        if (sparse.bufferView >= 0) {
            const Result<Values> before = open_accessor(model_, sparse, name);
            if (!before) return before.error();
            for (std::size_t i = 0; i < before->count; ++i)
                std::memcpy(&bytes[i * to->row], before->data + i * before->stride, to->row);
        }
        for (std::size_t i = 0; i < at->count; ++i) {
            const double place = at->at(i, 0);
            if (!(place >= 0 && place < static_cast<double>(sparse.count)))
                return malformed(name + " changes rows that it has not");
            std::memcpy(&bytes[static_cast<std::size_t>(place) * to->row], to->data + i * to->stride, to->row);
        }
        accessor(index).bufferView = add_view(std::move(bytes));
        accessor(index).byteOffset = 0;
        accessor(index).sparse.isSparse = false;
        return {};
    }

    tinygltf::Model& model_;
    std::uint64_t budget_;  // bytes that may still be unpacked
    std::map<int, DracoAccessors> draco_;
};

/// The objects of a list.
template <typename Visit>
void for_each(nlohmann::json& object, const char* list, Visit&& visit) {
    if (const auto found = object.find(list); found != object.end() && found->is_array())
        for (nlohmann::json& item : *found)
            if (item.is_object()) visit(item);
}

const nlohmann::json* extension_of(const nlohmann::json& object, const char* name) {
    const auto all = object.find("extensions");
    if (all == object.end() || !all->is_object()) return nullptr;
    const auto found = all->find(name);
    return found != all->end() && found->is_object() ? &*found : nullptr;
}

}  // namespace

bool complete_for_tinygltf(nlohmann::json& gltf) {
    bool changed = false;
    for_each(gltf, "buffers", [&](nlohmann::json& buffer) {
        if (buffer.contains("uri") || extension_of(buffer, kMeshoptExtension) == nullptr) return;
        buffer["uri"] = "data:application/octet-stream;base64,AA==";
        buffer["byteLength"] = 1;
        changed = true;
    });
    const auto accessors = gltf.find("accessors");
    if (accessors == gltf.end() || !accessors->is_array()) return changed;
    for_each(gltf, "meshes", [&](nlohmann::json& mesh) {
        for_each(mesh, "primitives", [&](nlohmann::json& primitive) {
            const nlohmann::json* draco = extension_of(primitive, kDracoExtension);
            if (draco == nullptr || !draco->contains("bufferView") || !primitive.contains("indices")) return;
            const nlohmann::json& index = primitive["indices"];
            if (!index.is_number_unsigned() || index.get<std::size_t>() >= accessors->size()) return;
            nlohmann::json& accessor = (*accessors)[index.get<std::size_t>()];
            if (!accessor.is_object() || accessor.contains("bufferView")) return;
            accessor["bufferView"] = (*draco)["bufferView"];
            changed = true;
        });
    });
    return changed;
}

Result<void> unpack(tinygltf::Model& model) {
    return Unpacker(model).run();
}

}  // namespace mvw
