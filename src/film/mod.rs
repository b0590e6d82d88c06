//! stub
use crate::color::*;
#[derive(Clone,Copy,Debug)] pub struct Split<L>{pub reflect:L,pub transmit:L}
#[derive(Clone,Copy,Debug,PartialEq)] pub enum Side{Outside,Inside}
pub struct Layer{pub index:IndexCurve,pub thickness_nm:f64}
pub struct Stack{pub outside:IndexCurve,pub layers:Vec<Layer>,pub base:IndexCurve,pub varying:Option<usize>,pub weight:f64}
#[derive(Clone,Copy,Debug)] pub enum Rung{Bare,ThreeWave,Gaussian,Table}
#[derive(Clone,Copy)] pub struct Range{pub min_nm:f64,pub max_nm:f64}
pub struct RgbFilm(f64,f64);
impl RgbFilm{ pub fn split(&self,_s:Side,c:f32,_t:f32)->Split<[f32;3]>{ let f0=(((1.-self.0).powi(2)+self.1*self.1)/((1.+self.0).powi(2)+self.1*self.1)) as f32; let r=f0+(1.-f0)*(1.-c).max(0.).powi(5); Split{reflect:[r;3],transmit:[1.-r;3]}}
 pub fn average(&self,_s:Side,_t:f32)->[f32;3]{[0.1;3]}}
#[derive(Clone,Debug,serde::Serialize)] pub struct Verdict{}
impl std::fmt::Display for Verdict{fn fmt(&self,_f:&mut std::fmt::Formatter)->std::fmt::Result{Ok(())}}
pub fn choose(s:&Stack,_r:Range,_se:&Sensor,_t:f64,_f:Option<Rung>)->(RgbFilm,Verdict){ let b=s.base.at(550.); (RgbFilm(b.re,b.im),Verdict{})}
