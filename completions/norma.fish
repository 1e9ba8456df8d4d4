# Completion of norma's command line for fish. Installed as share/fish/vendor_completions.d/norma.fish.
complete -c norma -f
complete -c norma -n __fish_use_subcommand -a compute -d 'Computes normals and writes them into a copy of a file'
complete -c norma -n __fish_use_subcommand -a transform -d 'Moves, turns, scales or mirrors a file, normals included'
complete -c norma -n __fish_use_subcommand -a matrix -d 'What a matrix does to normals'
complete -c norma -n __fish_use_subcommand -a info -d 'What is in a file'
complete -c norma -n __fish_use_subcommand -a help -d 'Shows what a verb takes'
complete -c norma -n __fish_use_subcommand -l version -d 'The version'
complete -c norma -n '__fish_seen_subcommand_from help' -a 'compute transform matrix info'
complete -c norma -l help -d 'What it takes, with examples'

set -l files '__fish_seen_subcommand_from compute transform'
complete -c norma -n "$files" -F
complete -c norma -n "$files" -s o -l output -r -F -d 'The output, in the format of the input'
complete -c norma -n "$files" -l out-dir -x -a '(__fish_complete_directories)' -d 'A folder for the outputs'
complete -c norma -n "$files" -l in-place -d 'Replace each input'

set -l reads '__fish_seen_subcommand_from compute transform info'
complete -c norma -n '__fish_seen_subcommand_from info' -F
complete -c norma -n "$reads" -l input-format -x -a 'obj ply stl gltf glb' -d 'Format of the inputs'
complete -c norma -n "$reads" -l threads -x -d 'How many may work'
complete -c norma -n "$reads" -l quiet -d 'Nothing but errors'
complete -c norma -n '__fish_seen_subcommand_from compute transform matrix info' -l json -d 'For programs'
complete -c norma -n '__fish_seen_subcommand_from info' -l deep -d 'Which weight and crease explain the stored normals'

set -l matrix '__fish_seen_subcommand_from transform matrix'
complete -c norma -n "$matrix" -l scale -x -d 'X,Y,Z or one number'
complete -c norma -n "$matrix" -l rotate -x -d 'X,Y,Z,DEG'
complete -c norma -n "$matrix" -l translate -x -d 'X,Y,Z'
complete -c norma -n "$matrix" -l matrix -x -d '16 numbers, row by row'
complete -c norma -n '__fish_seen_subcommand_from transform' -l bake -d 'Node transforms go into the meshes'

set -l compute '__fish_seen_subcommand_from compute'
complete -c norma -n "$compute" -l weight -x -a 'angle area uniform max angle-area visible angle-lengths' -d 'How faces are averaged'
complete -c norma -n "$compute" -l crease -x -d 'Edges that bend by more degrees are hard'
complete -c norma -n "$compute" -l smooth -d 'One normal per position'
complete -c norma -n "$compute" -l flat -d 'Each face is flat'
complete -c norma -n "$compute" -l groups -x -a 'auto ignore' -d 'OBJ smoothing groups'
complete -c norma -n "$compute" -l weld -x -a 'exact none' -d 'Which vertices share a normal'
complete -c norma -n "$compute" -l non-manifold -x -a 'hard smooth' -d 'Edges of three faces and more'
complete -c norma -n "$compute" -l only -x -a 'all missing broken' -d 'What is computed'
complete -c norma -n "$compute" -l morphs -d 'Normal deltas for all morph targets'
