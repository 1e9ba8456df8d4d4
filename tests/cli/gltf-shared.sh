#!/bin/bash
# glTF files in place whose buffers are not theirs alone, and companions with names that an attacker would choose: bytes that any asset of the folder names stay what they are.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
[ -x "$norma" ] || { fail "the tool is there" "no program at $norma"; finish; exit 1; }

near='\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\77\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\77\0\0\0\0' # (0,0,0) (1,0,0) (0,1,0)
far='\0\0\240\100\0\0\240\100\0\0\240\100\0\0\300\100\0\0\240\100\0\0\240\100\0\0\240\100\0\0\300\100\0\0\240\100' # the same by (5,5,5)

# triangle BYTELENGTH URI OFFSET [MEMBERS]: the text of an asset of one triangle.
triangle() {
    local low=0 high=1
    [ "$3" = 0 ] || { low=5 high=6; }
    printf '{"asset":{"version":"2.0"},%s"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[%d,%d,%d],"max":[%d,%d,%d]}],"bufferViews":[{"buffer":0,"byteOffset":%d,"byteLength":36}],"buffers":[{"byteLength":%d,"uri":"%s"}]}' \
        "${4:-}" $low $low $low $high $high $low "$3" "$1" "$2"
}

# place NAME: an empty folder, entered.
place() { mkdir -p "$scratch/$1" && cd "$scratch/$1" || exit 1; }
size() { stat -c %s "$1"; }
# same FIRST COUNT SECOND: equal in their first bytes.
same() { cmp -s -n "$2" "$1" "$3"; }
# bounds FILE: where it lies, and that it can be read.
bounds() { "$norma" check "$1" --no-config --quiet >/dev/null 2>&1; [ $? -lt 2 ] && "$norma" transform "$1" -o "$1.moved.gltf" --bake --quiet && grep -o '"min":\[[^]]*\]' "$1"; }

# ---- two assets, one file
place two
printf "$near$far" >s.bin
cp s.bin before.bin
triangle 36 s.bin 0 >a.gltf
triangle 72 s.bin 36 >b.gltf
"$norma" compute --in-place a.gltf --quiet
if [ "$(size s.bin)" = 108 ] && same s.bin 72 before.bin && grep -q '"byteLength":108' a.gltf && grep -q '"byteOffset":72' a.gltf; then
    pass "new normals go behind the end of the file, and the buffer says so"
else
    fail "new normals go behind the end of the file, and the buffer says so" "$(size s.bin) $(cat a.gltf)"
fi
"$norma" compute --in-place b.gltf --quiet
"$norma" transform --translate 0,0,2 --bake --in-place a.gltf --quiet
"$norma" check --fix-unsafe --in-place --no-config b.gltf --quiet >/dev/null
if same s.bin 72 before.bin && [ "$(bounds a.gltf)" = '"min":[0,0,2]' ] && [ "$(bounds b.gltf)" = '"min":[5,5,5]' ]; then
    pass "each asset is whole after the other was changed"
else
    fail "each asset is whole after the other was changed" "$(bounds a.gltf) $(bounds b.gltf)"
fi
grown=$(size s.bin)
for turn in 1 2 3 4 5 6; do
    for file in a b; do "$norma" transform --rotate 0,0,1,$((turn * 10)) --bake --in-place $file.gltf --quiet; done
done
if [ "$(size s.bin)" -le $((grown + 144)) ]; then pass "again and again, the file does not go on growing"; else fail "again and again, the file does not go on growing" "$grown -> $(size s.bin)"; fi

# ---- a copy of the asset as it was
place backup
printf "$near" >s.bin
triangle 36 s.bin 0 >a.gltf
"$norma" compute --in-place a.gltf --quiet
cp a.gltf a.gltf.bak
cp s.bin before.bin
for turn in 1 2 3; do "$norma" transform --rotate 0,0,1,$turn --bake --in-place a.gltf --quiet; done
if same s.bin 72 before.bin; then pass "what a backup of the asset names stays"; else fail "what a backup of the asset names stays"; fi

# ---- an asset in another folder of the same tree
for where in below link; do
    place tree-$where
    mkdir sub
    case $where in
    below) file=s.bin other=../s.bin name=s.bin ;;
    link) file=sub/real.bin other=real.bin name=link.bin && ln -s sub/real.bin link.bin ;;
    esac
    printf "$near$far" >$file
    cp $file before.bin
    triangle 72 $name 0 >a.gltf
    triangle 72 $other 36 >sub/b.gltf
    "$norma" compute --in-place a.gltf --quiet
    if [ "$(size $file)" = 108 ] && same $file 72 before.bin; then pass "what an asset in a subfolder names stays: $where"; else fail "what an asset in a subfolder names stays: $where" "$(size $file)"; fi
done
place hard
mkdir a b
printf "$near$far" >a/s.bin
ln a/s.bin b/s.bin
cp a/s.bin before.bin
triangle 72 s.bin 0 >a/a.gltf
"$norma" compute --in-place a/a.gltf --quiet
if cmp -s b/s.bin before.bin && ! cmp -s a/s.bin before.bin; then pass "another hard link of the buffer keeps its contents"; else fail "another hard link of the buffer keeps its contents"; fi
place alone
printf "$near$far" >s.bin
triangle 72 s.bin 0 >a.gltf
"$norma" compute --in-place a.gltf --quiet
if [ "$(size s.bin)" = 72 ]; then pass "what no asset names is used again"; else fail "what no asset names is used again" "$(size s.bin)"; fi

# ---- one asset, one file under two names
place twice
ln -s t.bin link.bin
for other in ./t.bin link.bin; do
    printf "$near$far" >t.bin
    cp t.bin before.bin
    triangle 36 t.bin 0 | sed "s|\"attributes\":{\"POSITION\":0}}|&,{\"attributes\":{\"POSITION\":1}}|; s|\"max\":\[1,1,0\]}|&,{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[5,5,5],\"max\":[6,6,5]}|; s|\"byteLength\":36}\]|\"byteLength\":36},{\"buffer\":1,\"byteOffset\":36,\"byteLength\":36}]|; s|\"uri\":\"t.bin\"}|&,{\"byteLength\":72,\"uri\":\"$other\"}|" >t.gltf
    cp t.gltf "$(basename $other).gltf"
    "$norma" transform --translate 0,0,1 --bake --in-place t.gltf --quiet
    if same t.bin 72 before.bin && [ "$(bounds t.gltf | tr '\n' ' ')" = '"min":[0,0,1] "min":[5,5,6] ' ]; then pass "a file named twice, as t.bin and $other"; else fail "a file named twice, as t.bin and $other" "$(bounds t.gltf)"; fi
done

# ---- files that are no data of an asset
place other
printf 'all:\n\tcc -o all all.c # a makefile of more than thirty-six bytes\n' >Makefile
cp Makefile notes.bin
printf '\211PNG\r\n\032\n%s' "$(head -c 40 /dev/zero | tr '\0' x)" >picture.bin
printf "$near" >.hidden.bin
ln -s Makefile link.bin
wrong=""
for name in Makefile notes.bin picture.bin .hidden.bin link.bin; do
    triangle 36 $name 0 >m.gltf
    cp $name before
    cp m.gltf m.before
    for verb in compute "transform --bake --scale 2" "check --fix-unsafe --no-config"; do
        # shellcheck disable=SC2086
        "$norma" $verb --in-place m.gltf >/dev/null 2>message
        status=$?
        cmp -s $name before && cmp -s m.gltf m.before || wrong+="$verb, $name: changed"$'\n'
        [ "${verb%% *}" = check ] || { [ $status = 3 ] && grep -q "$name does not look like data" message; } || wrong+="$verb, $name: $status $(cat message)"$'\n'
    done
done
if [ -z "$wrong" ]; then pass "no other file of the folder is taken for data"; else fail "no other file of the folder is taken for data" "$wrong"; fi

# ---- indices that name nothing
place dangling
printf "$near" >s.bin
for list in accessor:1 mesh:1; do
    case $list in
    accessor:1) members='"animations":[{"channels":[],"samplers":[{"input":1,"output":0}]}],' verb=compute ;;
    *) members='"extensions":{"SOME_list":{"mesh":1}},' verb="transform --bake --scale 2" ;;
    esac
    triangle 36 s.bin 0 "$members" >d.gltf
    [ $list = accessor:1 ] || sed -i 's/"nodes":\[0\]}\]/"nodes":[0,1]}]/; s/"nodes":\[{"mesh":0}\]/"nodes":[{"mesh":0},{"mesh":0,"scale":[1,2,1]}]/' d.gltf
    # shellcheck disable=SC2086
    "$norma" $verb d.gltf -o out.gltf >/dev/null 2>message
    if [ $? = 3 ] && grep -q "names ${list%:*} 1 of 1" message && [ ! -e out.gltf ]; then pass "no ${list%:*} is added where an index reaches beyond the last"; else fail "no ${list%:*} is added where an index reaches beyond the last" "$(cat message)"; fi
done

# ---- companions in another folder
place companions
png='\211PNG\r\n\032\n\0\0\0\0'
mkdir -p textures .config/autostart elsewhere
printf "$near" >s.bin
printf "$png" >textures/wood.png
printf "$png" >.hidden.png
printf "$png" >.config/autostart/x.png
printf 'alias ls=rm\n' >.bash_profile
printf '[Desktop Entry]\n' >.config/autostart/x.desktop
printf '#!/bin/sh\n' >script.png
printf "$png" >picture.sh
images='"images":[{"uri":"textures/wood.png"},{"uri":".hidden.png"},{"uri":".config/autostart/x.png"},{"uri":".bash_profile"},{"uri":".config/autostart/x.desktop"},{"uri":"script.png"},{"uri":"picture.sh"}],'
triangle 36 s.bin 0 "$images" >c.gltf
"$norma" compute c.gltf --out-dir out --quiet
found=$(cd out && find . -type f | sort | tr '\n' ' ')
if [ "$found" = "./c.bin ./c.gltf ./textures/wood.png " ]; then pass "only images go along"; else fail "only images go along" "$found"; fi

# One large image under a hundred names, which are one, and more images than files may be open.
mkdir many
{ printf "$png"; head -c 8000000 /dev/zero; } >large.png
for ((i = 0; i < 600; ++i)); do printf "$png" >many/$i.png; done
list=
dots=
for ((i = 0; i < 100; ++i)); do list+="{\"uri\":\"${dots}large.png\"},{\"uri\":\"large.png\"}," dots+=./; done
for ((i = 0; i < 600; ++i)); do list+="{\"uri\":\"many/$i.png\"},"; done
triangle 36 s.bin 0 "\"images\":[${list%,}]," >many.gltf
if (ulimit -n 256 && "$norma" compute many.gltf --out-dir crowd --quiet --max-memory 100M) 2>message && [ "$(find crowd -name '*.png' | wc -l)" = 601 ] && cmp -s large.png crowd/large.png; then
    pass "an image that is named often goes once, and many need few open files"
else
    fail "an image that is named often goes once, and many need few open files" "$(cat message; find crowd -name '*.png' | wc -l)"
fi

mkdir linked named
ln -s "$PWD/elsewhere" linked/textures
"$norma" compute c.gltf --out-dir linked --quiet 2>message
if [ $? = 3 ] && grep -q 'symbolic link' message && [ -z "$(ls elsewhere)" ]; then pass "no image is written through a link"; else fail "no image is written through a link" "$(cat message; ls elsewhere)"; fi
ln -s "$PWD/elsewhere/new.bin" named/c.bin
"$norma" compute c.gltf -o named/c.gltf --quiet 2>message
if [ $? = 3 ] && grep -q 'symbolic link' message && [ -z "$(ls elsewhere)" ]; then pass "no buffer is written through a link"; else fail "no buffer is written through a link" "$(cat message; ls elsewhere)"; fi

triangle 12 .bash_profile 0 >p.gltf
sed -i 's/"attributes":{"POSITION":0}/"attributes":{}/; s/"byteLength":36}\]/"byteLength":12}]/; s/"count":3/"count":1/' p.gltf
"$norma" compute p.gltf --out-dir profile --quiet 2>message
if [ ! -e profile/.bash_profile ]; then pass "no hidden file goes along as a buffer"; else fail "no hidden file goes along as a buffer" "$(cat message)"; fi
finish
