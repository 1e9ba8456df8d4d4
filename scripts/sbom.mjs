// sbom.mjs [--check]: writes docs/sbom.spdx.json, a bill of materials (SPDX 2.3), from what the project's own files say: the version in CMakeLists.txt, the least versions in
// cmake/dependencies.cmake and tests/CMakeLists.txt, and the npm packages that page and npm package contain and tests use, from their lock files. --check compares instead, and fails where it differs. The same files give the same bytes.
import { createHash } from "node:crypto";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const root = join(dirname(fileURLToPath(import.meta.url)), "..");
const read = (path) => readFileSync(join(root, path), "utf8");
const target = "docs/sbom.spdx.json";

const cmake = read("CMakeLists.txt"), dependencies = read("cmake/dependencies.cmake"), changes = read("CHANGELOG.md");
const version = /^project\(norma VERSION ([0-9.]+)/m.exec(cmake)[1];
const least = Object.fromEntries([...dependencies.matchAll(/^set\(norma_least_([a-z_]+) ([0-9.]+)\)/gm)].map(([, name, number]) => [name, number]));
const date = /[0-9]{4}-[0-9]{2}-[0-9]{2}/.exec(changes)?.[0] ?? "2026-11-21";

// name: licence, where it is from, what takes it and for what.
const known = {
    meshoptimizer: ["MIT", "https://github.com/zeux/meshoptimizer", "RUNTIME_DEPENDENCY_OF", "the library: decodes EXT_meshopt_compression", "libmeshoptimizer-dev"],
    draco: ["Apache-2.0", "https://github.com/google/draco", "RUNTIME_DEPENDENCY_OF", "the library: decodes KHR_draco_mesh_compression", "libdraco-dev"],
    jansson: ["MIT", "https://github.com/akheron/jansson", "TEST_DEPENDENCY_OF", "fuzz targets: a second reader of glTF", "libjansson-dev"],
    png: ["libpng-2.0", "http://www.libpng.org/pub/png/libpng.html", "RUNTIME_DEPENDENCY_OF", "the library: looks into normal maps; the tool: writes pictures", "libpng-dev"],
    jpeg: ["IJG AND BSD-3-Clause AND Zlib", "https://libjpeg-turbo.org/", "RUNTIME_DEPENDENCY_OF", "the library: looks into normal maps; the tool: reads images", "libjpeg-dev"],
    zlib: ["Zlib", "https://zlib.net/", "RUNTIME_DEPENDENCY_OF", "the library: the members of a 3MF", "zlib1g-dev"],
    egl_headers: ["Apache-2.0 AND MIT", "https://registry.khronos.org/EGL/", "BUILD_DEPENDENCY_OF", "the tool: headers of EGL and OpenGL ES 3; their libraries are opened when a picture is drawn", "libegl-dev, libgles-dev"],
    cmocka: ["Apache-2.0", "https://cmocka.org/", "TEST_DEPENDENCY_OF", "unit tests", "libcmocka-dev"],
    gmp: ["LGPL-3.0-or-later OR GPL-2.0-or-later", "https://gmplib.org/", "TEST_DEPENDENCY_OF", "the accuracy oracle", "libgmp-dev"],
};
for (const name of Object.keys(least))
    if (!known[name]) throw new Error(`cmake/dependencies.cmake names ${name}, of which scripts/sbom.mjs knows no licence`);
for (const name of Object.keys(known))
    if (!least[name]) throw new Error(`cmake/dependencies.cmake has no least version of ${name}`);

const packages = [{
    SPDXID: "SPDXRef-norma", name: "norma", versionInfo: version, downloadLocation: "NOASSERTION", filesAnalyzed: false,
    licenseConcluded: "MIT", licenseDeclared: "MIT", copyrightText: /^Copyright.*/m.exec(read("LICENSE"))[0], primaryPackagePurpose: "LIBRARY",
}];
const relationships = [{ spdxElementId: "SPDXRef-DOCUMENT", relationshipType: "DESCRIBES", relatedSpdxElement: "SPDXRef-norma" }];

function add(id, entry, relation) {
    const SPDXID = `SPDXRef-${id.replace(/[^a-zA-Z0-9.-]/g, "-")}`;
    if (packages.some((one) => one.SPDXID === SPDXID)) return;
    packages.push({ SPDXID, filesAnalyzed: false, copyrightText: "NOASSERTION", ...entry });
    relationships.push({ spdxElementId: SPDXID, relationshipType: relation, relatedSpdxElement: "SPDXRef-norma" });
}

for (const [name, [licence, from, relation, use, debian]] of Object.entries(known))
    add(name, {
        name, versionInfo: `>=${least[name]}`, downloadLocation: from, licenseConcluded: licence, licenseDeclared: licence, comment: `${use}; Debian: ${debian}`,
        externalRefs: debian.split(", ").map((one) => ({ referenceCategory: "PACKAGE-MANAGER", referenceType: "purl", referenceLocator: `pkg:deb/debian/${one}` })),
    }, relation);

add("open-sans", {
    name: "open-sans", versionInfo: "1.11", downloadLocation: "https://www.opensans.com/", licenseConcluded: "Apache-2.0", licenseDeclared: "Apache-2.0",
    comment: "the tool: outlines of the letters in pictures, src/render/outlines.h; Debian: fonts-open-sans",
    externalRefs: [{ referenceCategory: "PACKAGE-MANAGER", referenceType: "purl", referenceLocator: "pkg:deb/debian/fonts-open-sans" }],
}, "CONTAINED_BY");

for (const [folder, relation] of [["web", "CONTAINED_BY"], ["tests/cli/validator", "TEST_DEPENDENCY_OF"], ["tests/web", "TEST_DEPENDENCY_OF"], ["bench", "TEST_DEPENDENCY_OF"]]) {
    if (!existsSync(join(root, folder, "package-lock.json"))) continue;
    for (const [path, entry] of Object.entries(JSON.parse(read(`${folder}/package-lock.json`)).packages)) {
        if (!path) continue;
        const name = path.replace(/^.*node_modules\//, "");
        const checksum = entry.integrity?.startsWith("sha512-") ? [{ algorithm: "SHA512", checksumValue: Buffer.from(entry.integrity.slice(7), "base64").toString("hex") }] : undefined;
        add(`npm-${name}-${entry.version}`, {
            name, versionInfo: entry.version, downloadLocation: entry.resolved ?? "NOASSERTION", licenseConcluded: "NOASSERTION", licenseDeclared: entry.license ?? "NOASSERTION",
            checksums: checksum, comment: `${folder}/package-lock.json`,
            externalRefs: [{ referenceCategory: "PACKAGE-MANAGER", referenceType: "purl", referenceLocator: `pkg:npm/${name.replace("@", "%40")}@${entry.version}` }],
        }, name.startsWith("@types/") && relation === "CONTAINED_BY" ? "DEV_DEPENDENCY_OF" : relation);
    }
}

const digest = createHash("sha256").update(JSON.stringify([packages, relationships])).digest("hex");
const text = JSON.stringify({
    spdxVersion: "SPDX-2.3", dataLicense: "CC0-1.0", SPDXID: "SPDXRef-DOCUMENT", name: `norma-${version}`, documentNamespace: `https://spdx.org/spdxdocs/norma-${version}-${digest}`,
    creationInfo: { created: `${date}T00:00:00Z`, creators: ["Tool: scripts/sbom.mjs"] }, packages, relationships,
}, null, 2) + "\n";

if (process.argv[2] === "--check") {
    const same = existsSync(join(root, target)) && read(target) === text;
    console.log(same ? `${target} is current: ${packages.length} packages` : `${target} is not current; node scripts/sbom.mjs writes it`);
    process.exitCode = same ? 0 : 1;
} else {
    writeFileSync(join(root, target), text);
    console.log(`${target}: ${packages.length} packages`);
}
