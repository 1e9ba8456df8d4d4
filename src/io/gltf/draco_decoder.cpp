/* draco_decoder.cpp: libdraco behind an interface for C. The stream is not trusted: libdraco
 * allocates what counts in it ask for, so that these are compared with what the caller expects
 * before connectivity and before attributes are decoded. No exception leaves this file. */
#include "io/gltf/draco_decoder.h"
#include <cstring>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/compression/entropy/symbol_decoding.h>
#include <draco/core/varint_decoding.h>
#include <exception>
#include <limits>
#include <new>
#include <stdexcept>
#include <vector>

namespace {

struct Report {
    draco_result result = DRACO_BROKEN;
    size_t found = 0;
    bool Fail(draco_result why, size_t what) {
        result = why;
        found = what;
        return false;
    }
};

/* Where only the indices are in the stream, some programs write no points beside them. */
bool HasPoints(const draco_stream &stream, size_t points) {
    return stream.attribute_count ? points == stream.points : points <= stream.points;
}

/* Both ways of coding connectivity begin with two counts: the faces first where it is written as it
 * is (sequential), the vertices first where it is coded (edgebreaker). */
template <class Decoder, bool FacesFirst> class CheckedDecoder : public Decoder {
  public:
    CheckedDecoder(const draco_stream &stream, Report &report) : stream_(stream), report_(report) {}

  protected:
    bool DecodeGeometryData() override {
        draco::DecoderBuffer ahead = *this->buffer();
        uint32_t first = 0, second = 0;
        if (this->bitstream_version() != DRACO_BITSTREAM_VERSION(2, 2))
            return report_.Fail(DRACO_KIND, 0);
        if (!draco::DecodeVarint(&first, &ahead) || !draco::DecodeVarint(&second, &ahead))
            return false;
        const size_t faces = FacesFirst ? first : second;
        if (faces != stream_.faces) return report_.Fail(DRACO_FACES, faces);
        if (FacesFirst && !HasPoints(stream_, second)) return report_.Fail(DRACO_POINTS, second);
        return Decoder::DecodeGeometryData();
    }

    bool DecodeAllAttributes() override {
        const size_t points = this->point_cloud()->num_points();
        size_t size = 0;
        if (!HasPoints(stream_, points)) return report_.Fail(DRACO_POINTS, points);
        for (int i = 0; i < this->point_cloud()->num_attributes(); ++i) {
            const draco::PointAttribute *a = this->point_cloud()->attribute(i);
            const int width = a->num_components(); /* a signed byte there */
            if (width <= 0) return false;
            size += static_cast<size_t>(width) *
                    static_cast<size_t>(draco::DataTypeLength(a->data_type()));
        }
        if (points && size > stream_.most / points) return report_.Fail(DRACO_LARGE, size * points);
        return Decoder::DecodeAllAttributes();
    }

  private:
    const draco_stream &stream_;
    Report &report_;
};

/* Passes over the numbers of an attribute: symbols, or each in so many bytes. */
bool SkipValues(draco::DecoderBuffer *at, size_t count, int width) {
    uint8_t coded = 0, size = 0;
    if (!at->Decode(&coded)) return false;
    if (coded) {
        std::vector<uint32_t> symbols(count);
        return draco::DecodeSymbols(static_cast<uint32_t>(count), width, at, symbols.data());
    }
    if (!at->Decode(&size) || count > static_cast<size_t>(at->remaining_size()) / (size ? size : 1))
        return false;
    at->Advance(static_cast<int64_t>(count * size));
    return true;
}

/* Texture coordinates that are predicted by triangles come with a count of orientations that
 * libdraco allocates unseen, up to 256 MiB. It asks for these data when it has read by what an
 * attribute is predicted, so what follows can be looked at then. */
class Edgebreaker : public CheckedDecoder<draco::MeshEdgebreakerDecoder, false> {
  public:
    using CheckedDecoder::CheckedDecoder;

    const draco::MeshAttributeIndicesEncodingData *GetAttributeEncodingData(
        int attribute) const override {
        const auto *data = draco::MeshEdgebreakerDecoder::GetAttributeEncodingData(attribute);
        if (!data || HasOrientations(attribute, static_cast<size_t>(data->num_values))) return data;
        throw std::length_error("orientations");
    }

  private:
    bool HasOrientations(int attribute, size_t values) const {
        draco::DecoderBuffer ahead = *const_cast<Edgebreaker *>(this)->buffer();
        const int width = point_cloud()->attribute(attribute)->num_components();
        int32_t orientations = 0;
        if (ahead.decoded_size() < 2 ||
            ahead.data_head()[-2] != draco::MESH_PREDICTION_TEX_COORDS_PORTABLE)
            return true;
        return SkipValues(&ahead, values * static_cast<size_t>(width), width) &&
               ahead.Decode(&orientations) && orientations >= 0 &&
               static_cast<size_t>(orientations) <= 3 * size_t{mesh()->num_faces()};
    }
};

using Sequential = CheckedDecoder<draco::MeshSequentialDecoder, true>;

template <class Decoder>
bool DecodeBy(
    const draco_stream &stream, draco::DecoderBuffer *buffer, draco::Mesh *mesh, Report &report) {
    Decoder decoder(stream, report);
    const draco::DecoderOptions options;
    return decoder.Decode(options, buffer, mesh).ok();
}

bool DecodeMesh(const draco_stream &stream, draco::Mesh *mesh, Report &report) {
    draco::DecoderBuffer buffer, ahead;
    draco::DracoHeader header;
    buffer.Init(reinterpret_cast<const char *>(stream.bytes), stream.size);
    ahead = buffer;
    if (!draco::PointCloudDecoder::DecodeHeader(&ahead, &header).ok()) return false;
    if (header.encoder_type != draco::TRIANGULAR_MESH) return report.Fail(DRACO_KIND, 0);
    if (header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING)
        return DecodeBy<Edgebreaker>(stream, &buffer, mesh, report);
    if (header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING)
        return DecodeBy<Sequential>(stream, &buffer, mesh, report);
    return report.Fail(DRACO_KIND, 0);
}

/* ---- values */

/* Whether the attribute's memory holds the element. */
bool Holds(const draco::PointAttribute &a, uint32_t element) {
    const size_t stride = static_cast<size_t>(a.byte_stride());
    return a.buffer() && element < a.size() &&
           static_cast<size_t>(a.byte_offset()) + (element + size_t{1}) * stride <=
               a.buffer()->data_size();
}

template <class T>
bool CopyValues(
    const draco::PointAttribute &a, draco::DataType type, size_t points, unsigned char *out) {
    const int8_t width = static_cast<int8_t>(a.num_components());
    const size_t size = static_cast<size_t>(width) * sizeof(T);
    const bool same = a.data_type() == type && static_cast<size_t>(a.byte_stride()) == size;
    T element[4];
    for (uint32_t i = 0; i < points; ++i, out += size) {
        const draco::AttributeValueIndex value = a.mapped_index(draco::PointIndex(i));
        if (!Holds(a, value.value())) return false;
        if (same)
            a.GetValue(value, out);
        else if (a.ConvertValue<T>(value, width, element))
            std::memcpy(out, element, size);
        else
            return false;
    }
    return true;
}

bool CopyAttribute(const draco::PointAttribute &a, const draco_values &to, size_t points) {
    switch (to.component) {
    case 5120:
        return CopyValues<int8_t>(a, draco::DT_INT8, points, to.out);
    case 5121:
        return CopyValues<uint8_t>(a, draco::DT_UINT8, points, to.out);
    case 5122:
        return CopyValues<int16_t>(a, draco::DT_INT16, points, to.out);
    case 5123:
        return CopyValues<uint16_t>(a, draco::DT_UINT16, points, to.out);
    case 5125:
        return CopyValues<uint32_t>(a, draco::DT_UINT32, points, to.out);
    case 5126:
        return CopyValues<float>(a, draco::DT_FLOAT32, points, to.out);
    default:
        return false;
    }
}

bool CopyAttributes(const draco_stream &stream, const draco::Mesh &mesh, Report &report) {
    for (size_t i = 0; i < stream.attribute_count; ++i) {
        const draco_values &to = stream.attributes[i];
        const draco::PointAttribute *a = mesh.GetAttributeByUniqueId(to.id);
        if (!a) return report.Fail(DRACO_ATTRIBUTE, i);
        if (to.width > 4 || static_cast<uint32_t>(a->num_components()) != to.width)
            return report.Fail(DRACO_WIDTH, i);
        if (!CopyAttribute(*a, to, stream.points)) return report.Fail(DRACO_VALUE, i);
    }
    return true;
}

/* Little-endian, as glTF has them. */
bool CopyIndices(const draco_values &to, const draco::Mesh &mesh, size_t points, Report &report) {
    const unsigned size = to.component == 5121 ? 1 : to.component == 5123 ? 2 : 4;
    const uint32_t most = std::numeric_limits<uint32_t>::max() >> (32 - 8 * size);
    unsigned char *out = to.out;
    for (uint32_t f = 0; f < mesh.num_faces(); ++f)
        for (size_t k = 0; k < 3; ++k) {
            const uint32_t index = mesh.face(draco::FaceIndex(f))[k].value();
            if (index >= points) return report.Fail(DRACO_BROKEN, 0);
            if (index > most) return report.Fail(DRACO_VALUE, SIZE_MAX);
            for (unsigned b = 0; b < size; ++b)
                *out++ = static_cast<unsigned char>(index >> (8 * b) & 0xFF);
        }
    return true;
}

bool Decode(const draco_stream &stream, Report &report) {
    draco::Mesh mesh;
    if (!DecodeMesh(stream, &mesh, report)) return false;
    if (mesh.num_faces() != stream.faces) return report.Fail(DRACO_FACES, mesh.num_faces());
    return CopyAttributes(stream, mesh, report) &&
           (!stream.indices || CopyIndices(*stream.indices, mesh, stream.points, report));
}

} // namespace

extern "C" int norma_draco_reads(void) { return 1; }

extern "C" const char *norma_draco_missing(int) { return ""; }

extern "C" draco_result norma_draco_decode(const draco_stream *stream, size_t *found) {
    Report report;
    bool decoded = false;
    try {
        decoded = Decode(*stream, report);
    } catch (const std::bad_alloc &) {
        report.Fail(DRACO_MEMORY, 0);
    } catch (const std::exception &) { /* a length that no vector can have */
        report.Fail(DRACO_BROKEN, 0);
    } catch (...) {
        report.Fail(DRACO_BROKEN, 0);
    }
    *found = report.found;
    return decoded ? DRACO_OK : report.result;
}
