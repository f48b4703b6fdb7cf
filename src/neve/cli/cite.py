"""What to cite: each method that a scene can use, with the works that describe it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from neve.io.version import version

if TYPE_CHECKING:
    from neve.scene.schema.scene import Scene
from neve.scene.schema.snow import ELASTIC_LAWS

# Works by BibTeX key. Only what is certain stands here: authors, title, venue, pages, DOI.
WORKS: Mapping[str, str] = {
    "stomakhin2013": """@article{stomakhin2013,
  author  = {Stomakhin, Alexey and Schroeder, Craig and Chai, Lawrence and Teran, Joseph and Selle, Andrew},
  title   = {A material point method for snow simulation},
  journal = {ACM Transactions on Graphics},
  volume  = {32},
  number  = {4},
  year    = {2013},
  doi     = {10.1145/2461912.2461948}
}""",
    "sulsky1994": """@article{sulsky1994,
  author  = {Sulsky, Deborah and Chen, Zhen and Schreyer, Howard L.},
  title   = {A particle method for history-dependent materials},
  journal = {Computer Methods in Applied Mechanics and Engineering},
  volume  = {118},
  number  = {1--2},
  pages   = {179--196},
  year    = {1994},
  doi     = {10.1016/0045-7825(94)90112-0}
}""",
    "sulsky1995": """@article{sulsky1995,
  author  = {Sulsky, Deborah and Zhou, Shi-Jian and Schreyer, Howard L.},
  title   = {Application of a particle-in-cell method to solid mechanics},
  journal = {Computer Physics Communications},
  volume  = {87},
  number  = {1--2},
  pages   = {236--252},
  year    = {1995},
  doi     = {10.1016/0010-4655(94)00170-7}
}""",
    "steffen2008": """@article{steffen2008,
  author  = {Steffen, Michael and Kirby, Robert M. and Berzins, Martin},
  title   = {Analysis and reduction of quadrature errors in the material point method ({MPM})},
  journal = {International Journal for Numerical Methods in Engineering},
  volume  = {76},
  number  = {6},
  pages   = {922--948},
  year    = {2008},
  doi     = {10.1002/nme.2360}
}""",
    "jiang2015": """@article{jiang2015,
  author  = {Jiang, Chenfanfu and Schroeder, Craig and Selle, Andrew and Teran, Joseph and Stomakhin, Alexey},
  title   = {The affine particle-in-cell method},
  journal = {ACM Transactions on Graphics},
  volume  = {34},
  number  = {4},
  year    = {2015},
  doi     = {10.1145/2766996}
}""",
    "hu2018": """@article{hu2018,
  author  = {Hu, Yuanming and Fang, Yu and Ge, Ziheng and Qu, Ziyin and Zhu, Yixin and Pradhana, Andre
             and Jiang, Chenfanfu},
  title   = {A moving least squares material point method with displacement discontinuity and two-way rigid
             body coupling},
  journal = {ACM Transactions on Graphics},
  volume  = {37},
  number  = {4},
  year    = {2018},
  doi     = {10.1145/3197517.3201293}
}""",
    "harlow1964": """@article{harlow1964,
  author  = {Harlow, Francis H.},
  title   = {The particle-in-cell computing method for fluid dynamics},
  journal = {Methods in Computational Physics},
  volume  = {3},
  pages   = {319--343},
  year    = {1964}
}""",
    "fu2017": """@article{fu2017,
  author  = {Fu, Chuyuan and Guo, Qi and Gast, Theodore and Jiang, Chenfanfu and Teran, Joseph},
  title   = {A polynomial particle-in-cell method},
  journal = {ACM Transactions on Graphics},
  volume  = {36},
  number  = {6},
  year    = {2017},
  doi     = {10.1145/3130800.3130878}
}""",
    "fei2021": """@article{fei2021,
  author  = {Fei, Yun and Guo, Qi and Wu, Rundong and Huang, Li and Gao, Ming},
  title   = {Revisiting integration in the material point method: a scheme for easier separation and less
             dissipation},
  journal = {ACM Transactions on Graphics},
  volume  = {40},
  number  = {4},
  year    = {2021},
  doi     = {10.1145/3450626.3459678}
}""",
    "brackbill1986": """@article{brackbill1986,
  author  = {Brackbill, J. U. and Ruppel, H. M.},
  title   = {{FLIP}: A method for adaptively zoned, particle-in-cell calculations of fluid flows in two
             dimensions},
  journal = {Journal of Computational Physics},
  volume  = {65},
  number  = {2},
  pages   = {314--343},
  year    = {1986},
  doi     = {10.1016/0021-9991(86)90211-1}
}""",
    "zhu2005": """@article{zhu2005,
  author  = {Zhu, Yongning and Bridson, Robert},
  title   = {Animating sand as a fluid},
  journal = {ACM Transactions on Graphics},
  volume  = {24},
  number  = {3},
  pages   = {965--972},
  year    = {2005},
  doi     = {10.1145/1073204.1073298}
}""",
    "sifakis2012": """@inproceedings{sifakis2012,
  author    = {Sifakis, Eftychios and Barbi{\\v{c}}, Jernej},
  title     = {{FEM} simulation of {3D} deformable solids: a practitioner's guide to theory,
               discretization and model reduction},
  booktitle = {ACM SIGGRAPH 2012 Courses},
  year      = {2012},
  doi       = {10.1145/2343483.2343501}
}""",
    "klar2016": """@article{klar2016,
  author  = {Kl{\\'a}r, Gergely and Gast, Theodore and Pradhana, Andre and Fu, Chuyuan and
             Schroeder, Craig and Jiang, Chenfanfu and Teran, Joseph},
  title   = {{Drucker-Prager} elastoplasticity for sand animation},
  journal = {ACM Transactions on Graphics},
  volume  = {35},
  number  = {4},
  year    = {2016},
  doi     = {10.1145/2897824.2925906}
}""",
    "gaume2018": """@article{gaume2018,
  author  = {Gaume, Johan and Gast, Theodore and Teran, Joseph and van Herwijnen, Alec and Jiang, Chenfanfu},
  title   = {Dynamic anticrack propagation in snow},
  journal = {Nature Communications},
  volume  = {9},
  year    = {2018},
  doi     = {10.1038/s41467-018-05181-w}
}""",
    "li2020": """@article{li2020,
  author  = {Li, Xingyue and Sovilla, Betty and Jiang, Chenfanfu and Gaume, Johan},
  title   = {The mechanical origin of snow avalanche dynamics and flow regime transitions},
  journal = {The Cryosphere},
  volume  = {14},
  number  = {10},
  pages   = {3381--3398},
  year    = {2020},
  doi     = {10.5194/tc-14-3381-2020}
}""",
    "bridson2007": """@inproceedings{bridson2007,
  author    = {Bridson, Robert},
  title     = {Fast {Poisson} disk sampling in arbitrary dimensions},
  booktitle = {ACM SIGGRAPH 2007 Sketches},
  year      = {2007},
  doi       = {10.1145/1278780.1278807}
}""",
    "perlin1985": """@inproceedings{perlin1985,
  author    = {Perlin, Ken},
  title     = {An image synthesizer},
  booktitle = {Proceedings of SIGGRAPH '85},
  pages     = {287--296},
  year      = {1985},
  doi       = {10.1145/325334.325247}
}""",
    "worley1996": """@inproceedings{worley1996,
  author    = {Worley, Steven},
  title     = {A cellular texture basis function},
  booktitle = {Proceedings of SIGGRAPH '96},
  pages     = {291--294},
  year      = {1996},
  doi       = {10.1145/237170.237267}
}""",
    "jacobson2013": """@article{jacobson2013,
  author  = {Jacobson, Alec and Kavan, Ladislav and Sorkine-Hornung, Olga},
  title   = {Robust inside-outside segmentation using generalized winding numbers},
  journal = {ACM Transactions on Graphics},
  volume  = {32},
  number  = {4},
  year    = {2013},
  doi     = {10.1145/2461912.2461916}
}""",
    "barill2018": """@article{barill2018,
  author  = {Barill, Gavin and Dickson, Neil G. and Schmidt, Ryan and Levin, David I. W. and Jacobson, Alec},
  title   = {Fast winding numbers for soups and clouds},
  journal = {ACM Transactions on Graphics},
  volume  = {37},
  number  = {4},
  year    = {2018},
  doi     = {10.1145/3197517.3201337}
}""",
    "todorov2012": """@inproceedings{todorov2012,
  author    = {Todorov, Emanuel and Erez, Tom and Tassa, Yuval},
  title     = {{MuJoCo}: A physics engine for model-based control},
  booktitle = {2012 {IEEE/RSJ} International Conference on Intelligent Robots and Systems},
  pages     = {5026--5033},
  year      = {2012},
  doi       = {10.1109/IROS.2012.6386109}
}""",
}

# Method -> works that describe it. A method's name is the word that chooses it in a scene, or its table.
METHODS: Mapping[str, tuple[str, ...]] = {
    "mpm": ("sulsky1994", "sulsky1995"),
    "stomakhin2013": ("stomakhin2013",),
    "neo_hookean": ("sifakis2012",),
    "hencky": ("klar2016",),
    "drucker_prager": ("klar2016",),
    "cam_clay": ("gaume2018", "li2020"),
    "snow": ("stomakhin2013",),
    "quadratic": ("steffen2008",),
    "cubic": ("steffen2008",),
    "apic": ("jiang2015", "hu2018"),
    "flip": ("brackbill1986", "zhu2005"),
    "pic": ("harlow1964",),
    "polypic": ("fu2017", "jiang2015", "hu2018"),
    "asflip": ("fei2021", "jiang2015", "hu2018", "brackbill1986"),
    "poisson": ("bridson2007",),
    "fractal": ("perlin1985",),
    "clods": ("worley1996",),
    "mesh": ("jacobson2013", "barill2018"),
    "bodies": ("todorov2012",),
}


def methods(scene: Scene) -> list[str]:
    """Return the names of the methods that `scene` uses, in the order of the data path."""
    snows = [scene.snow_of(source) for source in scene.sources]
    laws: list[str] = [snow.law for snow in snows]
    if any(snow.law in ELASTIC_LAWS and snow.plasticity == "snow" for snow in snows):
        laws.append("snow")
    names = ["mpm", *laws, scene.numerics.spline, scene.numerics.transfer]
    if scene.numerics.sampling == "poisson":
        names.append("poisson")
    noises = [scene.completed(source).variation for source in scene.sources]
    names += [n.pattern for n in noises if n and (n.stiffness or n.strength or n.density)]
    if any(part.shape == "mesh" for part in (*scene.sources, *scene.colliders, *scene.bodies)):
        names.append("mesh")
    if scene.bodies or scene.robots:
        names.append("bodies")
    return list(dict.fromkeys(names))


def bibtex(scene: Scene) -> str:
    """Return BibTeX entries for Neve and for every work behind the methods of `scene`."""
    keys = dict.fromkeys(key for method in methods(scene) for key in METHODS[method])
    return "\n\n".join([_neve(), *(WORKS[key] for key in keys)]) + "\n"


def _neve() -> str:
    return f"""@software{{neve,
  author  = {{{{The Neve developers}}}},
  title   = {{Neve: a snow laboratory}},
  version = {{{version()}}}
}}"""
