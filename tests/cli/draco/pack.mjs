// pack.mjs MODULES METHOD IN OUT ...: packs glTF files with Draco by gltf-transform (METHOD: edgebreaker, sequential), OUT.glb; and unpacks each again by draco3d, OUT.plain.glb.
import { createRequire } from "node:module";
import { join } from "node:path";

const [, , modules, method, ...files] = process.argv;
const require = createRequire(join(modules, "from.js"));
const load = (name) => import(require.resolve(name));
const [{ NodeIO, Logger }, { ALL_EXTENSIONS }, { draco }] = await Promise.all(["core", "extensions", "functions"].map((name) => load(`@gltf-transform/${name}`)));
const draco3d = require("draco3dgltf");
const io = new NodeIO().setLogger(new Logger(Logger.Verbosity.ERROR)).registerExtensions(ALL_EXTENSIONS).registerDependencies({
    "draco3d.encoder": await draco3d.createEncoderModule(),
    "draco3d.decoder": await draco3d.createDecoderModule(),
});
for (let i = 0; i + 1 < files.length; i += 2) {
    const document = (await io.read(files[i])).setLogger(new Logger(Logger.Verbosity.ERROR));
    await document.transform(draco({ method }));
    await io.write(`${files[i + 1]}.glb`, document);
    const again = await io.read(`${files[i + 1]}.glb`);
    for (const extension of again.getRoot().listExtensionsUsed()) if (extension.extensionName === "KHR_draco_mesh_compression") extension.dispose();
    await io.write(`${files[i + 1]}.plain.glb`, again);
}
