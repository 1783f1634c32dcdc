//! speed
use antires_core::fem::frame::description::*;
use antires_core::fem::frame::dofs::Dimension;
use antires_core::fem::frame::*;
use antires_core::fem::model::Model;
use antires_core::fem::parameters::*;
use antires_core::fem::section::*;
use std::time::Instant;
#[test]
fn speed() {
    let n = 47;
    let nodes: Vec<[f64; 3]> = (0..=n)
        .map(|i| [i as f64 * 0.05, 0.02 * ((i % 5) as f64), 0.0])
        .collect();
    let sec = |t| Section {
        shape: Shape::Tube {
            outer_diameter_m: 0.038,
            thickness_m: t,
        },
        youngs_modulus_pa: 2.1e11,
        density_kg_per_m3: 7850.0,
        poisson: 0.3,
    };
    let d = FrameDescription {
        dimension: Dimension::Plane,
        nodes_m: nodes,
        beams: (0..n)
            .map(|i| Beam {
                nodes: [i, i + 1],
                section: i * 8 / n,
                reference: None,
            })
            .collect(),
        sections: (0..8).map(|i| sec(0.001 + 0.0001 * i as f64)).collect(),
        point_masses: (0..5)
            .map(|i| PointMass {
                node: 8 * i,
                mass_kg: 1.0,
                inertia_kg_m2: [0.01; 3],
            })
            .collect(),
        ground_springs: (0..8)
            .map(|i| GroundSpring {
                node: 5 * i,
                direction: i % 2,
                stiffness_n_per_m: 1e3,
            })
            .collect(),
        node_springs: vec![],
        fixed: vec![],
    };
    let model = Model::from_frame(Frame::new(d).unwrap()).unwrap();
    let frame = model.frame().unwrap();
    let damage: Vec<Parameter> = (17..47)
        .map(|i| Parameter {
            quantity: Quantity::StiffnessReduction,
            terms: vec![i],
        })
        .collect();
    let mut upd: Vec<Parameter> = vec![];
    for i in 0..8 {
        upd.push(Parameter {
            quantity: Quantity::Property(Property::Thickness, Scale::Value),
            terms: vec![i],
        });
    }
    for i in 0..4 {
        upd.push(Parameter {
            quantity: Quantity::Property(Property::YoungsModulus, Scale::Factor),
            terms: vec![2 * i],
        });
    }
    for i in 0..5 {
        upd.push(Parameter {
            quantity: Quantity::Property(Property::Mass, Scale::Factor),
            terms: vec![i],
        });
    }
    for i in 0..4 {
        let p = 10 * i + 3;
        upd.push(Parameter {
            quantity: Quantity::Angle(Angle {
                pivot: p,
                axis: [0.0, 0.0, 1.0],
            }),
            terms: frame.downstream(&[p], p).unwrap(),
        });
    }
    println!(
        "n = {}, {} positions",
        model.n_dof(),
        model.sparsity().len()
    );
    for (name, pars, x) in [
        ("damage", &damage, vec![0.3; 30]),
        ("one damaged", &damage, {
            let mut v = vec![0.0; 30];
            v[3] = 0.5;
            v
        }),
        ("updating 21", &upd, {
            let mut v = vec![0.0013; 8];
            v.extend([1.02; 4]);
            v.extend([1.1; 5]);
            v.extend([1.5; 4]);
            v
        }),
    ] {
        let mut a = Assembly::new(&model);
        for _ in 0..3 {
            let t = Instant::now();
            for _ in 0..10000 {
                a.form(&model, pars, &x);
            }
            println!("{name}: {:.2} us", t.elapsed().as_secs_f64() * 1e6 / 1e4);
        }
    }
}
