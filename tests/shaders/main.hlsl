// main.vert in HLSL; spirv-cross makes GLSL of it, which is then run.
#include "norma.hlsl"
struct In {
    float4 a0 : A0; float4 a1 : A1; float4 a2 : A2; float4 a3 : A3; float4 a4 : A4; float4 a5 : A5;
    float4 a6 : A6; float4 a7 : A7; float4 a8 : A8; float4 a9 : A9; float4 a10 : A10; uint4 a11 : A11;
};
struct Out {
    float4 o0 : O0; float4 o1 : O1; float4 o2 : O2; float4 o3 : O3; float4 o4 : O4; float4 o5 : O5; float4 o6 : O6;
    float4 o7 : O7; float4 o8 : O8; float4 o9 : O9; float4 o10 : O10; float4 o11 : O11; float4 o12 : O12; float4 o13 : O13;
    float4 position : SV_Position;
};

float4x4 whole(float3x3 m) { return float4x4(float4(m[0], 0.0), float4(m[1], 0.0), float4(m[2], 0.0), float4(0.0, 0.0, 0.0, 1.0)); }

Out main(In i) {
    float3x3 model = transpose(float3x3(i.a0.xyz, i.a1.xyz, i.a2.xyz)), second = transpose(float3x3(i.a6.xyz, i.a7.xyz, i.a8.xyz));
    float3x3 normal_matrix = norma_normal_matrix(model), columns = transpose(normal_matrix);
    float3 normal = norma_transform_normal(normal_matrix, i.a3.xyz);
    float4x4 none = whole(model) * 0.0;
    uint code = i.a11.x;
    Out o;
    o.o0 = float4(columns[0], norma_mirror_sign(model));
    o.o1 = float4(columns[1], 0.0);
    o.o2 = float4(columns[2], 0.0);
    o.o3 = float4(normal, 0.0);
    o.o4 = norma_transform_tangent(model, i.a4, normal);
    o.o5 = float4(norma_instance_normal(model, second, i.a3.xyz), 0.0);
    o.o6 = float4(norma_skin_normal(norma_skin_matrix(whole(model), whole(second), none, none, float4(i.a0.w, i.a1.w, 0.0, 0.0)), i.a3.xyz), 0.0);
    o.o7 = float4(norma_decode_octahedral_8(code), 0.0);
    o.o8 = float4(norma_decode_octahedral_12(code), 0.0);
    o.o9 = float4(norma_decode_octahedral_16(code), 0.0);
    o.o10 = float4(norma_decode_10_10_10_2(code), 0.0);
    o.o11 = float4(norma_perturb(i.a3.xyz, i.a4, i.a5.xyz, i.a5.w), 0.0);
    o.o12 = float4(norma_flat_normal(i.a10.xyz, i.a9.xyz), 0.0); // as if y ran up
    o.o13 = float4(norma_facing_normal(norma_decode_octahedral(i.a9.xy), i.a9.w > 0.0), 0.0);
    o.position = float4(0.0, 0.0, 0.0, 1.0);
    return o;
}
