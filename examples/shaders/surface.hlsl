// A surface lit by one lamp, with a normal map: HLSL. Matrices are column-major in the buffer, as they are by default.
#include "norma.hlsl"

cbuffer Object : register(b0) { float4x4 model, view_projection; };
Texture2D normal_map : register(t0);
SamplerState smooth : register(s0);

struct Vertex { float3 position : POSITION; float3 normal : NORMAL; float4 tangent : TANGENT; float2 uv : TEXCOORD; };
struct Surface { float4 position : SV_Position; float3 normal : NORMAL; float4 tangent : TANGENT; float2 uv : TEXCOORD; };

Surface vertex_main(Vertex vertex) {
    Surface surface;
    surface.position = mul(view_projection, mul(model, float4(vertex.position, 1.0)));
    surface.normal = norma_transform_normal(norma_normal_matrix((float3x3)model), vertex.normal);
    surface.tangent = norma_transform_tangent((float3x3)model, vertex.tangent, surface.normal);
    surface.uv = vertex.uv;
    return surface;
}

float4 pixel_main(Surface surface, bool front : SV_IsFrontFace) : SV_Target {
    float3 normal = norma_perturb(norma_facing_normal(surface.normal, front), surface.tangent, normal_map.Sample(smooth, surface.uv).xyz, 1.0);
    return float4(max(dot(normal, float3(0.0, 0.6, 0.8)), 0.0).xxx, 1.0);
}
