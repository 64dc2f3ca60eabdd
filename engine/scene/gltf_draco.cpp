#include "engine/scene/gltf_draco.h"

#include "base/input_error.h"
#include "engine/scene/gltf_text.h"

#include <draco/compression/decode.h>

#include <algorithm>
#include <string>

namespace springdrive::scene::gltf {

struct DracoMesh::Decoded {
    std::unique_ptr<draco::Mesh> mesh;
};

namespace {

/// The largest integer of a type, by which a normalised value is divided; 1 for floats.
double full_scale(draco::DataType type) {
    switch (type) {
    case draco::DT_INT8:
        return 127.0;
    case draco::DT_UINT8:
        return 255.0;
    case draco::DT_INT16:
        return 32767.0;
    case draco::DT_UINT16:
        return 65535.0;
    default:
        return 1.0;
    }
}

} // namespace

DracoMesh::DracoMesh(std::span<const unsigned char> bytes) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char *>(bytes.data()), bytes.size());
    const auto type = draco::Decoder::GetEncodedGeometryType(&buffer);
    if (!type.ok() || type.value() != draco::TRIANGULAR_MESH) {
        throw InputError("its Draco data hold no triangle mesh");
    }
    draco::Decoder decoder;
    auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
    if (!mesh.ok()) {
        throw InputError("its Draco data are damaged: " +
                         one_line(mesh.status().error_msg_string()));
    }
    decoded_ = std::make_unique<Decoded>(Decoded{std::move(mesh).value()});
}

DracoMesh::~DracoMesh() = default;

std::vector<std::array<std::uint32_t, 3>> DracoMesh::triangles() const {
    const draco::Mesh &mesh = *decoded_->mesh;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    triangles.reserve(mesh.num_faces());
    for (std::uint32_t i = 0; i < mesh.num_faces(); ++i) {
        const draco::Mesh::Face &face = mesh.face(draco::FaceIndex(i));
        triangles.push_back({face[0].value(), face[1].value(), face[2].value()});
    }
    return triangles;
}

Attribute DracoMesh::attribute(std::uint32_t id, bool normalised) const {
    const draco::Mesh &mesh = *decoded_->mesh;
    const draco::PointAttribute *const source = mesh.GetAttributeByUniqueId(id);
    if (source == nullptr || source->num_components() < 2 || source->num_components() > 4) {
        throw InputError("its Draco data hold no vectors with the id " + std::to_string(id));
    }
    // Where Draco itself knows that the integers are normalised, it has divided already.
    const bool divide = normalised && !source->normalized();
    const double scale = divide ? full_scale(source->data_type()) : 1.0;
    const auto width = static_cast<std::size_t>(source->num_components());
    Attribute attribute{static_cast<int>(width),
                        std::vector<double>(std::size_t{mesh.num_points()} * width)};
    for (std::uint32_t point = 0; point < mesh.num_points(); ++point) {
        const draco::AttributeValueIndex value = source->mapped_index(draco::PointIndex(point));
        double *const target = &attribute.values[point * width];
        if (value.value() >= source->size() || !source->ConvertValue<double>(value, target)) {
            throw InputError("its Draco data cannot be read as numbers");
        }
        if (divide) {
            std::transform(target, target + width, target,
                           [&](double number) { return std::max(number / scale, -1.0); });
        }
    }
    return attribute;
}

} // namespace springdrive::scene::gltf
