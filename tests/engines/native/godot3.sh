#!/bin/bash
# Godot 3 imports the scene and draws it by its GLES3 renderer.   godot3.sh SCENE.glb SHOT.png
# It knows no unlit materials, so those of marks and labels are set; lights are dimmed to what it can show.
set -eu
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cp "$1" "$scratch/scene.glb"
cat >"$scratch/project.godot" <<'END'
config_version=4
[application]
run/main_scene="res://shot.tscn"
[display]
window/size/width=1600
window/size/height=1200
END
cat >"$scratch/shot.tscn" <<'END'
[gd_scene load_steps=2 format=2]
[ext_resource path="res://shot.gd" type="Script" id=1]
[node name="Shot" type="Spatial"]
script = ExtResource( 1 )
END
cat >"$scratch/shot.gd" <<'END'
extends Spatial

func prepare(node):
	if node is Light:
		node.light_energy = 0.9
	if node is MeshInstance:
		for i in range(node.mesh.get_surface_count()):
			var material = node.mesh.surface_get_material(i)
			if material and material.resource_name in ["red", "green", "blue", "yellow", "ink", "black"]:
				material.flags_unshaded = true
	for child in node.get_children():
		prepare(child)
func _ready():
	var scene = load("res://scene.glb").instance()
	prepare(scene)
	add_child(scene)
	var camera = Camera.new()
	camera.environment = Environment.new()
	camera.environment.background_mode = Environment.BG_COLOR
	camera.environment.background_color = Color(0.46, 0.46, 0.46)
	camera.environment.ambient_light_energy = 0.0
	camera.set_orthogonal(12, 0.1, 20)
	camera.translation = Vector3(0, 0, 10)
	add_child(camera)
	camera.current = true
	for _i in range(3):
		yield(get_tree(), "idle_frame")
	var image = get_viewport().get_texture().get_data()
	image.flip_y()
	image.save_png("res://shot.png")
	get_tree().quit()
END
for task in "--editor --quit" ""; do # the first imports the scene, and does not always end by itself
    # shellcheck disable=SC2086  # words
    timeout 120 xvfb-run -a -s "-screen 0 1600x1200x24" godot3 $task --video-driver GLES3 --audio-driver Dummy --path "$scratch" >/dev/null 2>&1 || true
done
mv "$scratch/shot.png" "$2"
echo "Godot $(godot3 --version | sed 's/\.stable.*//')"
