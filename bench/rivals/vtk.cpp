// VTK: its fast filter for triangle meshes, and the one that splits at feature edges.
#include "rival.hpp"
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataNormals.h>
#include <vtkTriangleMeshPointNormals.h>

using namespace rival;

static void fill(vtkPolyData *data, const Mesh &mesh) {
    vtkNew<vtkPoints> points;
    points->SetDataTypeToFloat();
    points->SetNumberOfPoints(vtkIdType(mesh.vertex_count()));
    for (size_t v = 0; v < mesh.vertex_count(); ++v)
        points->SetPoint(vtkIdType(v), mesh.positions[3 * v], mesh.positions[3 * v + 1],
            mesh.positions[3 * v + 2]);
    vtkNew<vtkCellArray> cells;
    for (size_t t = 0; t < mesh.triangles.size(); t += 3) {
        const vtkIdType ids[3] = {vtkIdType(mesh.triangles[t]), vtkIdType(mesh.triangles[t + 1]),
            vtkIdType(mesh.triangles[t + 2])};
        cells->InsertNextCell(3, ids);
    }
    data->SetPoints(points);
    data->SetPolys(cells);
}

int main(int count, char **arguments) {
    for (bool shuffled : {false, true}) {
        const Mesh mesh = make(asked_triangles(count, arguments, 2000000), shuffled);
        const double copy = copy_seconds(12 * mesh.triangle_count());
        vtkNew<vtkPolyData> data;
        fill(data, mesh);
        vtkNew<vtkTriangleMeshPointNormals> fast;
        fast->SetInputData(data);
        double seconds = least(
            5, [&] { fast->Modified(); }, [&] { fast->Update(); });
        vtkDataArray *normals = fast->GetOutput()->GetPointData()->GetNormals();
        const double off = largest_angle(reference(mesh, Weight::area),
            [&](size_t v, int k) { return normals->GetComponent(vtkIdType(v), k); });
        print("VTK " VTK_VERSION_TEXT, "TriangleMeshPointNormals", "area", mesh.shape,
            mesh.triangle_count(), seconds, copy, off);
        vtkNew<vtkPolyDataNormals> splitting;
        splitting->SetInputData(data);
        splitting->SetFeatureAngle(60);
        splitting->SplittingOn();
        splitting->ConsistencyOff();
        seconds = least(
            1, [&] { splitting->Modified(); }, [&] { splitting->Update(); });
        print("VTK " VTK_VERSION_TEXT, "PolyDataNormals, splitting at 60", "uniform", mesh.shape,
            mesh.triangle_count(), seconds, copy, -1);
    }
    return 0;
}
