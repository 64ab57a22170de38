//! Reads a data set grasp by grasp: `cargo run --release --example data_set out/small`, after
//! `cargo run --release -- dataset scenes/paper_small.ron -o out/small`.

use tactus::base::error::{Error, Result};
use tactus::dataset::DataSet;

fn main() -> Result<()> {
    let dir = std::env::args().nth(1).ok_or_else(|| Error::Start("the folder of a data set is missing".into()))?;
    let set = DataSet::open(dir)?;
    println!("{}", set.manifest.about);
    for object in &set.objects {
        let nodes = object.sizes.nodes;
        println!("{}: {} grasps reached their force; a pad has {nodes} nodes", object.name, object.reached().count());
        let Some(first) = object.reached().next() else { continue };
        let grasp = object.grasp(first)?;
        let last = &grasp.displacement[grasp.displacement.len() / grasp.frames * (grasp.frames - 1)..];
        let largest = last.chunks_exact(3).map(|u| u.iter().map(|x| x * x).sum::<f32>().sqrt()).fold(0.0, f32::max);
        println!(
            "  grasp {first}: {:.1} N, largest displacement {:.3} mm",
            grasp.force[grasp.frames - 1],
            1e3 * largest
        );
    }
    let (train, test) = (set.select(&set.splits.poses.train).len(), set.select(&set.splits.poses.test).len());
    println!("{train} grasps for training, {test} for testing");
    Ok(())
}
