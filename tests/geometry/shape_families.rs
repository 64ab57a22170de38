//! Every generated object is closed, oriented outwards and has the correct mass properties; invalid parameters are
//! refused by name.

use crate::shape_common::{families, real_meshes};
use glam::{DMat3, DVec2, DVec3};
use std::collections::HashSet;
use std::f64::consts::PI;
use tactus::geometry::mesh::TriMesh;
use tactus::geometry::shape::{MassProperties, Shape, ShapeKind, SurfaceDefinition, generate};

#[test]
fn every_family_is_closed_and_without_repeated_vertices() {
    for segments in [8, 9, 64] {
        for shape in families(segments) {
            let mesh = &shape.surface;
            let again = Shape::from_mesh(TriMesh::clone(mesh)).unwrap_or_else(|e| panic!("{}: {e}", shape.name));
            assert_eq!(again.surface, shape.surface, "{}: wound inwards", shape.name);
            assert!(again.mass.volume > 0.0);
            let places: HashSet<_> =
                mesh.vertices.iter().map(|p| p.to_array().map(|x| (x * 1e9).round() as i64)).collect();
            assert_eq!(places.len(), mesh.vertices.len(), "{}: repeated vertices", shape.name);
            assert!(mesh.triangles.len() < 300_000);
        }
    }
}

#[test]
fn boxes_around_contain_the_surface_and_touch_it() {
    for shape in families(32) {
        let reach = shape.surface.vertices.iter().fold(0.0, |r: f64, p| r.max(p.length()));
        assert!(
            reach <= shape.bounding_radius * (1.0 + 1e-14) && reach > 0.97 * shape.bounding_radius,
            "{}",
            shape.name
        );
        for p in &shape.surface.vertices {
            assert!((*p - shape.aabb.max).max(shape.aabb.min - *p).max_element() < 1e-15, "{}: {p}", shape.name);
        }
        for axis in DVec3::AXES {
            let (low, high) = shape.extent(axis);
            assert!((low - shape.aabb.min.dot(axis)).abs() < 1e-15 && (high - shape.aabb.max.dot(axis)).abs() < 1e-15);
        }
    }
}

#[test]
fn masses_in_closed_form_are_the_limit_of_those_of_meshes() {
    for shape in families(512).into_iter().filter(|s| matches!(s.definition, SurfaceDefinition::ClosedForm)) {
        let (exact, mesh) = (shape.mass, MassProperties::of_mesh(&shape.surface));
        let name = &shape.name;
        assert!((mesh.volume / exact.volume - 1.0).abs() < 2e-4, "{name}: {} m3 against {}", mesh.volume, exact.volume);
        assert!(mesh.center.distance(exact.center) < 1e-5 * shape.bounding_radius, "{name}: {}", mesh.center);
        let size = exact.inertia.x_axis.x;
        let difference = (mesh.inertia - exact.inertia).to_cols_array().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        assert!(difference < 4e-4 * size, "{name}: {difference} of {size} m5");
    }
}

#[test]
fn masses_are_those_of_the_textbook() {
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} against {b}");
    let box_ = Shape::from_mesh(TriMesh::clone(&generate::cuboid(DVec3::new(1.0, 2.0, 3.0), 0.0, 8).unwrap().surface));
    let m = box_.unwrap().mass;
    close(m.volume, 6.0);
    close(m.inertia.x_axis.x, 6.0 * (4.0 + 9.0) / 12.0);
    let (r, h) = (0.3, 0.8);
    let m = generate::cylinder(r, h, 16).unwrap().mass;
    close(m.volume, PI * r * r * h);
    close(m.inertia.z_axis.z, m.volume * r * r / 2.0);
    close(m.inertia.x_axis.x, m.volume * (3.0 * r * r + h * h) / 12.0);
    let m = generate::annulus(0.3, 0.2, h, 16).unwrap().mass;
    close(m.volume, PI * (0.09 - 0.04) * h);
    close(m.inertia.z_axis.z, m.volume * (0.09 + 0.04) / 2.0);
    let m = generate::sphere(r, 16).unwrap().mass;
    assert!(m.inertia.abs_diff_eq(DMat3::from_diagonal(DVec3::splat(0.4 * m.volume * r * r)), 1e-16));
}

#[test]
fn mass_does_not_depend_on_where_the_object_is() {
    for (name, mesh) in real_meshes() {
        let here = MassProperties::of_mesh(&mesh);
        let offset = DVec3::new(3.0, -5.0, 7.0);
        let mut far = mesh;
        far.vertices.iter_mut().for_each(|p| *p += offset);
        let there = MassProperties::of_mesh(&far);
        assert!(here.volume > 0.0 && (there.volume / here.volume - 1.0).abs() < 1e-9, "{name}");
        assert!((there.center - offset).distance(here.center) < 1e-9, "{name}: centre in m");
        let size = here.inertia.x_axis.x;
        assert!(there.inertia.abs_diff_eq(here.inertia, 1e-8 * size), "{name}");
    }
}

#[test]
fn wrong_parameters_are_refused_by_name() {
    let sphere = |radius| ShapeKind::Sphere { radius };
    let cuboid = |edge_radius| ShapeKind::Cuboid { size: DVec3::new(0.02, 0.04, 0.04), edge_radius };
    let line = |points: &[(f64, f64)], closed| ShapeKind::Revolve {
        profile: points.iter().map(|&p| DVec2::from(p)).collect(),
        closed,
    };
    let tube = |path: &[[f64; 3]], radii: &[f64]| ShapeKind::Sweep {
        path: path.iter().map(|&p| DVec3::from_array(p)).collect(),
        radii: radii.to_vec(),
    };
    let cases = [
        (sphere(-1.0), "sphere: radius is -1 m; it must be between 1e-6 and 100 m (is it in metres?)"),
        (sphere(f64::NAN), "sphere: radius is NaN m"),
        (sphere(f64::INFINITY), "sphere: radius is inf m"),
        (ShapeKind::Ellipsoid { semi_axes: DVec3::new(1.0, 0.0, 1.0) }, "ellipsoid: semi-axis y is 0 m"),
        (ShapeKind::Ellipsoid { semi_axes: DVec3::new(1.0, 1e-4, 1.0) }, "differ by more than a factor of 1000"),
        (cuboid(0.01), "cuboid: edge_radius is 0.01 m; it must be 0, or between 1e-6 m and less than half"),
        (cuboid(f64::NAN), "cuboid: edge_radius is NaN m"),
        (
            ShapeKind::Capsule { radius: 0.02, length: 0.03 },
            "capsule: length 0.03 m must be at least twice the radius 0.02 m",
        ),
        (ShapeKind::Prism { sides: 2, radius: 0.02, height: 0.03 }, "prism: sides is 2; it must be between 3 and 512"),
        (
            ShapeKind::Annulus { outer_radius: 0.02, inner_radius: 0.03, height: 0.01 },
            "annulus: inner_radius 0.03 m must be less",
        ),
        (
            ShapeKind::Cup { radius: 0.02, height: 0.03, wall: 0.02 },
            "cup: wall 0.02 m must be at most 0.9 of the radius",
        ),
        (
            ShapeKind::Banana { length: 0.1, diameter: 0.03, bend: 4.0 },
            "banana: bend is 4 rad; it must be between 0.01 and 3",
        ),
        (ShapeKind::Potato { semi_axes: DVec3::ONE, roughness: 0.5, seed: 0 }, "potato: roughness is 0.5"),
        (line(&[(0.0, 0.0), (1.0, 1.0)], false), "revolve: the profile has 2 points; it must have 3 to 2048"),
        (
            line(&[(0.1, 0.0), (1.0, 1.0), (0.0, 2.0)], false),
            "it must have rho = 0: a profile that is not a loop ends on the axis",
        ),
        (
            line(&[(0.0, 0.0), (-1.0, 1.0), (0.0, 2.0)], false),
            "revolve: profile point 1 is (rho, z) = (-1, 1) m; it must have rho > 0",
        ),
        (line(&[(0.0, 0.0), (1.0, 1.0), (1.0, 1.0), (0.0, 2.0)], false), "is repeated"),
        (line(&[(1.0, 0.0), (2.0, 1.0), (2.0, 0.0), (1.0, 1.0)], true), "revolve: the profile crosses itself near"),
        (tube(&[[0.0; 3], [1.0, 0.0, 0.0]], &[0.1]), "sweep: 1 radii for 2 path points; give one for each"),
        (tube(&[[0.0; 3], [0.0; 3]], &[0.1, 0.1]), "sweep: path point 1 repeats the one before"),
        (tube(&[[0.0; 3], [0.1, 0.0, 0.0], [0.1, 0.1, 0.0]], &[0.2; 3]), "bends too sharply"),
    ];
    for (kind, message) in cases {
        let error = kind.build(16).expect_err(message).to_string();
        assert!(error.contains(message), "{kind:?}: {error}");
    }
    for segments in [0, 7, 513, u32::MAX] {
        let error = sphere(0.02).build(segments).unwrap_err().to_string();
        assert_eq!(error, format!("sphere: segments is {segments}; it must be between 8 and 512"));
    }
}

#[test]
fn meshes_that_bound_no_solid_are_refused_with_the_place() {
    let cube = || TriMesh::clone(&generate::cuboid(DVec3::splat(2.0), 0.0, 8).unwrap().surface);
    let refused = |mesh: TriMesh| Shape::from_mesh(mesh).unwrap_err().to_string();
    assert!(refused(TriMesh::default()).contains("has no triangles"));
    let mut open = cube();
    open.triangles.remove(0);
    let message = refused(open);
    assert!(message.contains("is open: 3 edges with one triangle only, the first from (-1.000000, "), "{message}");
    let mut twisted = cube();
    twisted.triangles[3].swap(0, 1);
    assert!(
        refused(twisted).contains("is not oriented consistently: 3 edges whose triangles disagree, the first from (")
    );
    let mut flat = cube();
    flat.triangles[2] = [0, 1, 0];
    assert!(refused(flat).contains("triangle 2 of the object's mesh, near (-1.000000, "));
    let mut lost = cube();
    lost.triangles[2] = [0, 1, 99];
    assert!(refused(lost).contains("triangle 2 of the object's mesh uses vertex 99, but there are only 8"));
    let mut wild = cube();
    wild.vertices[4].y = f64::NAN;
    assert!(refused(wild).contains("vertex 4 of the object's mesh is at"));
    let mut double = cube();
    double.triangles.extend(cube().triangles);
    assert!(refused(double).contains("18 edges with three or more triangles"));
    let sheet = TriMesh { vertices: cube().vertices, triangles: vec![[0, 1, 2], [0, 2, 1]] };
    assert!(refused(sheet).contains("it is closed but encloses no volume"));
    let mut spare = cube();
    spare.vertices.insert(0, DVec3::splat(9.0));
    spare.triangles.iter_mut().flatten().for_each(|v| *v += 1);
    let spare = Shape::from_mesh(spare).unwrap();
    assert_eq!((spare.surface.vertices.len(), spare.aabb.max), (8, DVec3::ONE));
    let mut inward = cube();
    inward.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let turned = Shape::from_mesh(inward).unwrap();
    assert!(turned.distance.distance(DVec3::ZERO) == -1.0 && turned.mass.volume > 0.0);
}

#[test]
fn a_potato_is_decided_by_its_seed() {
    let potato = |seed| generate::potato(DVec3::new(0.04, 0.03, 0.025), 0.1, seed, 20).unwrap().surface;
    assert_eq!(potato(1), potato(1));
    assert_ne!(potato(1), potato(2));
}

/// Every family of shapes as written in a scene, at its default or a typical size.
const IN_SCENES: [&str; 16] = [
    "Sphere(radius: 0.02)",
    "Ellipsoid(radii: (0.03, 0.02, 0.015))",
    "Cuboid(size: (0.03, 0.04, 0.05), edge_radius: 0.004)",
    "Cylinder(radius: 0.02, height: 0.05)",
    "Capsule(radius: 0.015, height: 0.03)",
    "Prism(sides: 6, radius: 0.02, height: 0.05)",
    "Prism(sides: 8, radius: 0.02, height: 0.05)",
    "Annulus(outer: 0.02, inner: 0.012, height: 0.03)",
    "Cup(radius: 0.03, height: 0.06, wall: 0.003)",
    "Lemon()",
    "Strawberry()",
    "Pear()",
    "Banana()",
    "Potato()",
    "Revolve(profile: [(0, -0.02), (0.02, 0), (0, 0.02)])",
    "Sweep(path: [(0, 0, -0.03), (0, 0.005, 0), (0, 0, 0.03)], radii: [0.01])",
];

#[test]
fn every_family_goes_from_a_scene_to_a_watertight_obj_of_graspable_size() {
    let dir = tempfile::tempdir().unwrap();
    for shape in IN_SCENES {
        let (scene, obj) = (dir.path().join("s.ron"), dir.path().join("s.obj"));
        std::fs::write(&scene, format!("(object: (shape: {shape}), loading: Squeeze(force: 5))")).unwrap();
        let scene = tactus::scene::load(&scene).unwrap_or_else(|e| panic!("{shape}: {e}")).scene;
        let built = tactus::model::part::object::build(&scene.object, &mut Vec::new()).unwrap();
        tactus::geometry::mesh::io::write_obj(&obj, &built.surface).unwrap();
        let (mesh, notices) = tactus::geometry::mesh::io::read_tri_mesh(&obj).unwrap();
        assert!(notices.is_empty(), "{shape}: {notices:?}");
        assert!(tactus::geometry::mesh::topology::check_edges(&mesh).is_solid(), "{shape}");
        assert_eq!(mesh, *built.surface, "{shape}: the same vertices to the bit");
        let narrowest = built.aabb.size().min_element();
        assert!((0.005..0.08).contains(&narrowest), "{shape}: {narrowest} m between the pads");
    }
}
