//! Centerlines.
mod ball; mod cover; mod fork; mod line; mod route; mod skin; mod spline; mod tube;
use std::sync::atomic::AtomicBool;
use glam::DVec3;
use rayon::prelude::*;
use crate::mesh::surface::Surface;
use crate::mesh::report::NONE;
use self::{cover::Cover, fork::{Fork,Line,Network}, route::Skeleton, skin::{Ball,Skin}};
/// x
pub struct Found { pub points: Vec<DVec3>, pub radius: Vec<f64>, pub parent: Vec<u32>, pub ends: Vec<Option<u32>>, pub degrees: Vec<usize>, pub lines: usize }
/// x
pub fn centerline(surface: Surface, source: DVec3, targets: &[DVec3], cancel: &AtomicBool) -> Option<Found> {
    let t=std::time::Instant::now();
    let skin=Skin::new(surface);
    let t1=std::time::Instant::now();
    let mut cover=Cover::new(&skin,cancel)?;
    let t2=std::time::Instant::now();
    let mut end=|p: DVec3| { let h=skin.surface.picker().nearest(p.as_vec3(),f32::INFINITY)?; let f=skin.surface.faces()[h.triangle as usize];
        let n=f.iter().zip(h.barycentric.to_array()).map(|(v,w)| skin.normals[*v as usize]*f64::from(w)).sum::<DVec3>().normalize_or_zero();
        let b=skin.ball(h.point,n)?; let id=cover.push(b); for v in f { let o=cover.of_vertex[v as usize]; if o!=NONE { cover.link(id,o); } } Some(id) };
    let src=end(source)?; let tg: Vec<u32>=targets.iter().filter_map(|t| end(*t)).collect();
    let sk=Skeleton::new(&cover,src,&tg,cancel)?;
    let chains=sk.chains();
    let t3=std::time::Instant::now();
    let lines: Vec<Line>=chains.par_iter().map(|c| { let b: Vec<Ball>=c.iter().map(|n| sk.balls[*n as usize]).collect(); Line { from: c[0], to: *c.last().unwrap(), samples: line::centred(&skin,&b) } }).collect();
    let t4=std::time::Instant::now();
    let mut forks: Vec<Fork>=sk.balls.iter().map(|b| Fork{ball:*b,lines:0}).collect();
    for l in &lines { forks[l.from as usize].lines+=1; forks[l.to as usize].lines+=1; }
     let mut net=Network{forks,lines};

    net.join(&skin);
    let t5=std::time::Instant::now();
    println!("  skin {:?} cover {:?} ({} balls) route {:?} ({} chains) lines {:?} join {:?}",t1-t,t2-t1,cover.balls.len(),t3-t2,chains.len(),t4-t3,t5-t4);
    if std::env::var("D").is_ok() { for l in &net.lines { println!("  final {} {}",l.from,l.to); for x in &l.samples { println!("    f {:.3} {:.3} {:.3} r {:.3} {}",x.point.x,x.point.y,x.point.z,x.radius,x.tube.is_some()); } } }
 // tree
    let mut f=Found{points:vec![net.lines.first().map(|l| l.samples[0].point)?],radius:vec![net.lines[0].samples[0].radius],parent:vec![NONE],ends:vec![],degrees:vec![],lines:net.lines.len()};
    let mut node=vec![NONE;net.forks.len()]; node[0]=0;
    for l in &net.lines { let mut at=node[l.from as usize]; for s in &l.samples[1..] { f.points.push(s.point); f.radius.push(s.radius); f.parent.push(at); at=f.points.len() as u32-1; } node[l.to as usize]=at; }
    f.ends=sk.ends.iter().map(|e| e.map(|e| node[e as usize]).filter(|e| *e!=NONE)).collect();
    f.degrees=net.forks.iter().enumerate().filter(|(i,k)| k.lines>2 && node[*i]!=NONE).map(|(_,k)| k.lines-1).collect();
    f.degrees.sort();
    Some(f)
}
